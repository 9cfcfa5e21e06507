/* A libclang for tests. It reports MESSAGE as an error where that is defined. */
typedef struct {
    const void *data;
    unsigned flags;
} String;

void *clang_createIndex(int exclude, int display) {
    (void)exclude, (void)display;
    return "index";
}

int clang_parseTranslationUnit2(void *index, const char *source, const char *const *arguments, int count, void *unsaved,
                                unsigned unsaved_count, unsigned options, void **unit) {
    (void)index, (void)source, (void)arguments, (void)count, (void)unsaved, (void)unsaved_count, (void)options;
    *unit = "unit";
    return 0;
}

#ifdef MESSAGE
unsigned clang_getNumDiagnostics(void *unit) {
    (void)unit;
    return 1;
}
#else
#define MESSAGE ""
unsigned clang_getNumDiagnostics(void *unit) {
    (void)unit;
    return 0;
}
#endif

void *clang_getDiagnostic(void *unit, unsigned index) {
    (void)index;
    return unit;
}

int clang_getDiagnosticSeverity(void *diagnostic) {
    (void)diagnostic;
    return 3;
}

String clang_getDiagnosticSpelling(void *diagnostic) {
    (void)diagnostic;
    return (String){MESSAGE, 0};
}

const char *clang_getCString(String string) { return string.data; }
