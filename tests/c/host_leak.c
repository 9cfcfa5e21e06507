/* Leaks that leak checks must find: host_leak <directory> leaks a mesh and a context. */
#include "host.h"

int main(int argc, char **argv)
{
    icoray_mesh *mesh = NULL;
    (void)argc;
    (void)argv;
    OK(icoray_mesh_create(1, &mesh));
    CHECK(mesh != NULL);
    mesh = NULL;
    return verdict("host_leak");
}
