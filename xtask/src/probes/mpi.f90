! Prints the library that is linked.
program probe
  use mpi_f08
  implicit none
  character(MPI_MAX_LIBRARY_VERSION_STRING) :: version
  integer :: length
  call MPI_Get_library_version(version, length)
  print '(a)', version(:length)
end program probe
