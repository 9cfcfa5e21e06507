#include <netcdf.h>
#include <netcdf_meta.h>
#include <stdio.h>

int main(void) {
    printf("%s\n", nc_inq_libvers());
    return !NC_HAS_NC4;
}
