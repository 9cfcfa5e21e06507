/* Scenes that are refused. */
#include "refusals.h"

#define DEEP 100000
#define PLACED(lat) "[camera]\nlon = 0\nlat = " lat "\ndistance = 3\n"
#define COLORED(map) "[transfer]\nmap = \"" map "\"\nrange = [0, 1]\nopacity = [[0, 0.5]]\n"

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
        {"field = \"\"\n" PLACED("0") COLORED("viridis"), "line 1"},
        {"field = \"f\"\n" PLACED("95") COLORED("viridis"), "line 4, key camera.lat: 95"},
        {"field = \"f\"\nexaggeration = nan\n" PLACED("0") COLORED("viridis"), "line 2, key exaggeration: NaN"},
        {"field = \"f\"\n" PLACED("0") COLORED("jet"), "line 7, key transfer.map"},
        {"field = \"f\"\n" PLACED("0") COLORED("viridis") "[output]\nfile = \"f.gif\"\n", "line 11, key output.file"},
        {"field = \"f\"\ntolerance = 0\n" PLACED("0") COLORED("viridis"), "line 2, key tolerance: 0, expected"},
        {SCENE("f", "4", "f.png") "error = \"f.png\"\n", "line 16, key output.error: \"f.png\""},
    };
    const char *path;
    char *deep = (char *)allocate(DEEP + 5, 1);
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        REFUSED(ctx, SCENE, cases[i].part, icoray_scene_text(ctx, cases[i].text));
        path = in_output("bad.toml");
        CHECK(write_file(path, cases[i].text));
        REFUSED(ctx, SCENE, cases[i].part, icoray_scene_load(ctx, path));
        REFUSED(ctx, SCENE, path, icoray_scene_load(ctx, path));
    }
    trying = "";
    REFUSED(ctx, ARGUMENT, "UTF-8", icoray_scene_text(ctx, NO_UTF8));
    REFUSED(ctx, ARGUMENT, "UTF-8", icoray_scene_load(ctx, NO_UTF8));
    path = in_output("missing.toml");
    REFUSED(ctx, IO, text_of("%s: cannot read the scene", path), icoray_scene_load(ctx, path));
    REFUSED(ctx, IO, directory, icoray_scene_load(ctx, directory));
    REFUSED(ctx, IO, "cannot read the scene", icoray_scene_load(ctx, ""));
    path = in_output("bytes.toml");
    CHECK(write_file(path, "field = \"" NO_UTF8 "\"\n"));
    REFUSED(ctx, IO, path, icoray_scene_load(ctx, path));

    /* Brackets without end would overflow the stack of a careless parser. */
    memcpy(deep, "f = ", 4);
    memset(deep + 4, '[', DEEP);
    REFUSED(ctx, SCENE, "bad scene", icoray_scene_text(ctx, deep));
    free(deep);

    /* A good file; and a scene that is good by itself and asks for what is not there. */
    path = in_output("good.toml");
    CHECK(write_file(path, good_scene));
    OK(icoray_scene_load(ctx, path));
    still_draws(ctx);
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    NOT_DRAWN(ctx, FIELD, "\"q\"");
    NOT_DRAWN(ctx, FIELD, "given: [\"f\"");
    OK(icoray_scene_text(ctx, SCENE("f", "0.5", "q.png")));
    NOT_DRAWN(ctx, SCENE, "inside the opaque core");
    CHECK(!file_exists("q.png"));
    OK(icoray_scene_text(ctx, good_scene));
}

/* The names of fields of views and conditions, each once. */
void fields_of_scenes(void)
{
    static const char *const views = "camera = { lon = 0, lat = 45, distance = 3 }\n"
                                     "transfer = { map = \"plasma\", range = [0, 1], opacity = [[0, 0], [1, 0.5]] }\n"
                                     "[[views]]\nname = \"a\"\nfield = \"theta\"\nwhen = \"max(w) > 2\"\n"
                                     "[[views]]\nname = \"b\"\nfield = \"w\"\nevery = 3\n";
    static const char *const expected[] = {"theta", "w", "", ""};
    icoray_ctx *ctx = opened();
    char name[8] = "before";
    trying = "fields of scenes";
    REFUSED(NULL, NULL, "ctx", icoray_scene_field(NULL, 0, name, sizeof name));
    REFUSED(ctx, ORDER, "icoray_scene_load", icoray_scene_field(ctx, 0, name, sizeof name));
    OK(icoray_scene_text(ctx, "# nothing\n"));
    OK(icoray_scene_field(ctx, 0, name, sizeof name));
    CHECK(name[0] == 0);
    OK(icoray_scene_text(ctx, views));
    for (size_t i = 0; i < COUNT(expected); i++) {
        OK(icoray_scene_field(ctx, (int64_t)i, name, sizeof name));
        CHECK(strcmp(name, expected[i]) == 0);
    }
    REFUSED(ctx, ARGUMENT, "index: -1", icoray_scene_field(ctx, -1, name, sizeof name));
    REFUSED(ctx, ARGUMENT, "len: 5, expected at least 6", icoray_scene_field(ctx, 0, name, 5));
    REFUSED(ctx, NULL, "name", icoray_scene_field(ctx, 0, NULL, 8));
    OK(icoray_scene_field(ctx, 0, name, 6));
    OK(icoray_close(&ctx));
}

/* No scene is a mistake; one of nothing but comments and blanks draws nothing. */
void empty_scenes(void)
{
    static const char *const empty[] = {"", "\n", "# nothing\n", " \t\r\n\n# nothing", "#"};
    const char *path = in_output("empty.toml");
    icoray_ctx *ctx = opened();
    int32_t any, f;
    for (size_t i = 0; i < COUNT(empty); i++) {
        trying = empty[i];
        NOT_DRAWN(ctx, ORDER, "scene");
        CHECK(write_file(path, empty[i]));
        for (int from_file = 0; from_file < 2; from_file++) {
            OK(from_file ? icoray_scene_load(ctx, path) : icoray_scene_text(ctx, empty[i]));
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
    REFUSED(ctx, SCENE, "line 1 (nothing)", icoray_scene_text(ctx, "nothing"));
    DRAW(ctx, 901, 0.0, NULL);
    CHECK(!file_exists("f_900.png") && !file_exists("f_901.png"));
    CHECK(report_of(ctx).frames_written == 1 && report_of(ctx).frames_failed == 0);
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    /* A scene that names no field shows the one that was set first. */
    OK(icoray_scene_text(ctx, "image = { width = 16, height = 16 }\n[output]\nfile = \"first_{field}.png\"\n"));
    OK(icoray_wants_field(ctx, "f", 0, 0.0, &f));
    OK(icoray_wants_field(ctx, "another", 0, 0.0, &any));
    CHECK(f == 1 && any == 0);
    DRAW(ctx, 0, 0.0, NULL);
    CHECK(file_exists("first_f.png"));
    OK(icoray_close(&ctx));
}
