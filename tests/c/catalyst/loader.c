/* Runs a host that is in a shared library, whose symbols nobody else sees, as those of a module of Python: loader LIBRARY
 * and the host's arguments. */
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

int main(int argc, char **argv)
{
    int (*host)(int, char **);
    void *library = argc > 1 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    void *symbol = library != NULL ? dlsym(library, "host_main") : NULL;
    if (symbol == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    memcpy(&host, &symbol, sizeof host);
    return host(argc - 1, argv + 1);
}
