/* Uses libclang as bindgen does: `probe LIBCLANG HEADER ARGUMENTS...` loads the library, parses a header, and fails with the
   first error of the loader or of clang. Declares what it uses of clang-c/Index.h, which the library does not need. */
#include <dlfcn.h>
#include <stdio.h>

typedef struct {
    const void *data;
    unsigned flags;
} String;

static void *library;

static void *function(const char *name) {
    void *found = dlsym(library, name);
    if (!found) printf("%s\n", dlerror());
    return found;
}

int main(int count, char **arguments) {
    if (count < 3) return 2;
    library = dlopen(arguments[1], RTLD_LAZY | RTLD_LOCAL);
    if (!library) {
        printf("%s\n", dlerror());
        return 1;
    }
    void *(*create)(int, int) = (void *(*)(int, int))function("clang_createIndex");
    int (*parse)(void *, const char *, const char *const *, int, void *, unsigned, unsigned, void **) =
        (int (*)(void *, const char *, const char *const *, int, void *, unsigned, unsigned, void **))function(
            "clang_parseTranslationUnit2");
    unsigned (*diagnostics)(void *) = (unsigned (*)(void *))function("clang_getNumDiagnostics");
    void *(*diagnostic)(void *, unsigned) = (void *(*)(void *, unsigned))function("clang_getDiagnostic");
    int (*severity)(void *) = (int (*)(void *))function("clang_getDiagnosticSeverity");
    String (*spelling)(void *) = (String(*)(void *))function("clang_getDiagnosticSpelling");
    const char *(*text)(String) = (const char *(*)(String))function("clang_getCString");
    if (!create || !parse || !diagnostics || !diagnostic || !severity || !spelling || !text) return 1;

    void *unit = 0;
    int error = parse(create(0, 0), arguments[2], (const char *const *)arguments + 3, count - 3, 0, 0, 0, &unit);
    if (error || !unit) {
        printf("clang cannot parse a header (error %d)\n", error);
        return 1;
    }
    for (unsigned i = 0; i < diagnostics(unit); ++i) {
        void *found = diagnostic(unit, i);
        if (severity(found) >= 3) {
            printf("%s\n", text(spelling(found)));
            return 1;
        }
    }
    return 0;
}
