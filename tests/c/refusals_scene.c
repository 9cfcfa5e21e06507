/* Scenes that are refused. */
#include "refusals.h"

#define DEEP 100000

void scenes(icoray_ctx *ctx)
{
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"tolerance = 0.9\n", "line 1, key tolerance: 0.9"},
        {"background = \"none\"\n", "did you mean \"transparent\"?"},
        {"field = 3\n", "line 1 (field = 3)"},
        {"field = \"f\"\n\n[image\n", "line 3 ([image)"},
        {"field = \"f\"\ncolour = 1\n", "line 2 (colour = 1)"},
        {"field = \"\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"viridis\"\n", "line 1"},
        {"field = \"f\"\n[camera]\nlon = 0\nlat = 95\ndistance = 3\n[transfer]\nmap = \"viridis\"\nrange = [0, 1]\n"
         "opacity = [[0, 0.5]]\n",
         "line 4, key camera.lat: 95"},
        {"field = \"f\"\nexaggeration = nan\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"viridis\"\n"
         "range = [0, 1]\nopacity = [[0, 0.5]]\n",
         "line 2, key exaggeration: NaN"},
        {"field = \"f\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"jet\"\nrange = [0, 1]\n"
         "opacity = [[0, 0.5]]\n",
         "line 7, key transfer.map"},
        {"field = \"f\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"viridis\"\nrange = [0, 1]\n"
         "opacity = [[0, 0.5]]\n[output]\nfile = \"f.gif\"\n",
         "line 11, key output.file"},
        {"field = \"f\"\ntolerance = 0\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"viridis\"\n"
         "range = [0, 1]\nopacity = [[0, 0.5]]\n",
         "line 2, key tolerance: 0, expected"},
        {SCENE("f", "4", "f.png") "error = \"f.png\"\n", "line 16, key output.error: \"f.png\""},
    };
    char path[1024], words[1200];
    char *deep = (char *)malloc(DEEP + 5);
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        REFUSED(ctx, ICORAY_ERR_SCENE, cases[i].part, icoray_scene_text(ctx, cases[i].text));
        path_of(path, sizeof path, "bad.toml");
        CHECK(write_file(path, cases[i].text));
        REFUSED(ctx, ICORAY_ERR_SCENE, cases[i].part, icoray_scene_load(ctx, path));
        REFUSED(ctx, ICORAY_ERR_SCENE, path, icoray_scene_load(ctx, path));
    }
    trying = "";
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "UTF-8", icoray_scene_text(ctx, NO_UTF8));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "UTF-8", icoray_scene_load(ctx, NO_UTF8));
    path_of(path, sizeof path, "missing.toml");
    snprintf(words, sizeof words, "%s: cannot read the scene", path);
    REFUSED(ctx, ICORAY_ERR_IO, words, icoray_scene_load(ctx, path));
    REFUSED(ctx, ICORAY_ERR_IO, directory, icoray_scene_load(ctx, directory));
    REFUSED(ctx, ICORAY_ERR_IO, "cannot read the scene", icoray_scene_load(ctx, ""));
    path_of(path, sizeof path, "bytes.toml");
    CHECK(write_file(path, "field = \"" NO_UTF8 "\"\n"));
    REFUSED(ctx, ICORAY_ERR_IO, path, icoray_scene_load(ctx, path));

    /* Brackets without end would overflow the stack of a careless parser. */
    if (deep != NULL) {
        memcpy(deep, "f = ", 4);
        memset(deep + 4, '[', DEEP);
        deep[DEEP + 4] = '\0';
        REFUSED(ctx, ICORAY_ERR_SCENE, "bad scene", icoray_scene_text(ctx, deep));
        free(deep);
    }

    /* A good file; and a scene that is good by itself and asks for what is not there. */
    path_of(path, sizeof path, "good.toml");
    CHECK(write_file(path, good_scene));
    OK(icoray_scene_load(ctx, path));
    still_draws(ctx);
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    REFUSED(ctx, ICORAY_ERR_FIELD, "\"q\"", icoray_execute(ctx, 0, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_FIELD, "given: [\"f\"", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_scene_text(ctx, SCENE("f", "0.5", "q.png")));
    REFUSED(ctx, ICORAY_ERR_SCENE, "inside the opaque core", icoray_execute(ctx, 0, 0.0, NULL));
    CHECK(!file_exists("q.png"));
    OK(icoray_scene_text(ctx, good_scene));
}

/* No scene is a mistake; one of nothing but comments and blanks draws nothing. */
void empty_scenes(void)
{
    static const char *const empty[] = {"", "\n", "# nothing\n", " \t\r\n\n# nothing", "#"};
    icoray_ctx *ctx = opened();
    char path[1024];
    int32_t any, f;
    for (size_t i = 0; i < COUNT(empty); i++) {
        trying = empty[i];
        REFUSED(ctx, ICORAY_ERR_ORDER, "scene", icoray_execute(ctx, 0, 0.0, NULL));
        for (int from_file = 0; from_file < 2; from_file++) {
            if (from_file) {
                path_of(path, sizeof path, "empty.toml");
                CHECK(write_file(path, empty[i]));
                OK(icoray_scene_load(ctx, path));
            } else {
                OK(icoray_scene_text(ctx, empty[i]));
            }
            any = f = 7;
            OK(icoray_wants(ctx, 0, 0.0, &any));
            OK(icoray_wants_field(ctx, "f", 0, 0.0, &f));
            CHECK(any == 0 && f == 0);
            OK(icoray_execute(ctx, 0, 0.0, NULL)); /* without grid, layers or field */
            OK(icoray_execute(ctx, INT64_MIN, 0.0, "no date"));
        }
        OK(icoray_close(&ctx));
        ctx = opened();
    }
    /* In place of a scene it ends the drawing; a refused one does not. */
    OK(icoray_close(&ctx));
    ctx = filled();
    still_draws(ctx);
    OK(icoray_scene_text(ctx, "# nothing\n"));
    OK(icoray_execute(ctx, 900, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_SCENE, "line 1 (nothing)", icoray_scene_text(ctx, "nothing"));
    OK(icoray_execute(ctx, 901, 0.0, NULL));
    OK(icoray_wait(ctx));
    CHECK(!file_exists("f_900.png") && !file_exists("f_901.png"));
    CHECK(report_of(ctx).frames_written == 1 && report_of(ctx).frames_failed == 0);
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    /* A scene that names no field shows the one that was set first. */
    OK(icoray_scene_text(ctx, "image = { width = 16, height = 16 }\n[output]\nfile = \"first_{field}.png\"\n"));
    OK(icoray_wants_field(ctx, "f", 0, 0.0, &f));
    OK(icoray_wants_field(ctx, "another", 0, 0.0, &any));
    CHECK(f == 1 && any == 0);
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_wait(ctx));
    CHECK(file_exists("first_f.png"));
    OK(icoray_close(&ctx));
    trying = "";
}
