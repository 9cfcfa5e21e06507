/* A context of one process in a job of several ranks: a warning at rank 0, once. mpi_serial DIRECTORY */
#include "mpi_common.h"

static int warnings;

static void counts(void *user, int32_t level, const char *message)
{
    (void)user;
    warnings += level == ICORAY_LOG_WARN && strstr(message, "icoray_open_serial in a job of") != NULL;
}

static void open_and_close(const char *directory, int expected)
{
    icoray_ctx *ctx = NULL;
    icoray_config config = CONFIG(.output_dir = directory, .log = counts, .log_level = ICORAY_LOG_WARN);
    OK(icoray_open_serial(&config, &ctx));
    OK(icoray_close(&ctx));
    CHECK(warnings == expected);
}

int main(int argc, char **argv)
{
    int expected;
    begin(&argc, &argv);
    expected = rank == 0 && ranks > 1;
    open_and_close(argv[1], expected);
    open_and_close(argv[1], expected);
    return end("mpi_serial");
}
