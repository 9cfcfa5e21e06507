/*
 * tracer: a small transport model that draws itself with icoray while it runs.
 *
 * Two bells of a passive tracer are carried by the prescribed three-dimensional deformational flow of DCMIP test 1-1
 * (Kent, Ullrich and Jablonowski 2014, doi:10.1002/qj.2208). The flow reverses half way, so that after 12 days the
 * exact solution is the initial field and the error can be measured.
 *
 *   cc -std=c99 -O2 -o tracer tracer.c mesh.c options.c ranks.c transport.c winds.c -licoray -lm
 *
 * Over MPI, with an icoray that was installed with --mpi: each rank computes the whole model and draws tiles of each picture,
 * which has the bytes of the one above (ranks.c has all of MPI):
 *
 *   mpicc -DTRACER_MPI -std=c99 -O2 -o tracer tracer.c mesh.c options.c ranks.c transport.c winds.c -licoray -lm
 *   mpirun -n 2 ./tracer --threads 1 --scene ../scenes/tracer.toml
 *
 * The model is in the other files. All that it adds in order to be drawn stands here, under "what a model adds".
 */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */

#include "mesh.h"
#include "options.h"
#include "planet.h"
#include "ranks.h"
#include "transport.h"
#include "winds.h"

#include <icoray.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define MAX_COURANT 0.6 /* of the default time step */

/* ---- what a model adds ---- */

typedef struct {
    icoray_ctx *ctx; /* NULL after a failure: the simulation goes on without pictures */
    icoray_array q;  /* where the tracer is */
    int taken, failed;
    char trouble[1100];            /* why a call failed on this rank; empty if none did */
    double seconds;                /* wall-clock time inside icoray */
    double prepare, render;        /* the parts of it that the frame reports name */
    double write;                  /* encoding and disk, on a thread of icoray's beside the model */
    double worst, mean, p999;      /* errors of the pictures: largest, sum of the means, largest 99.9th percentile */
    double tolerance;              /* what the scene allows */
    int estimates;                 /* pictures whose errors are estimates, not bounds */
} Pictures;

static double wall_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Checks one status. On an error, keeps what is to be said. */
static int succeeded(Pictures *pictures, icoray_status status, const char *call)
{
    char message[1024] = "";
    if (status == ICORAY_OK) {
        return 1;
    }
    (void)icoray_last_error(pictures->ctx, message, sizeof message);
    snprintf(pictures->trouble, sizeof pictures->trouble, "%s: status %d: %s", call, (int)status, message);
    return 0;
}

/* On all ranks together: where any is in trouble, the first says why, and none draws any more. */
static void settle(Pictures *pictures)
{
    int first = ranks_first(pictures->trouble[0] != '\0');
    if (first < 0) {
        return;
    }
    if (first == ranks_me()) {
        fprintf(stderr, "tracer: %s\ntracer: the simulation goes on without pictures\n", pictures->trouble);
    }
    pictures->trouble[0] = '\0';
    (void)icoray_close(&pictures->ctx);
}

/* Once, before the time loop: hands over the mesh and the layers, and reads the scene. */
static Pictures pictures_open(const icoray_grid *grid, const Mesh *mesh, const State *s, const Options *options)
{
    Pictures pictures = {0};
    double start = wall_clock();

    icoray_config config = {0};
    config.struct_size = sizeof config;
    config.threads = options->threads;
    config.output_dir = options->out;

    icoray_layers layers = {0};
    layers.struct_size = sizeof layers;
    layers.count = mesh->layers;
    layers.radius_m = mesh->radius;
    layers.planet_radius_m = RADIUS;

    icoray_array *q = &pictures.q;
    q->struct_size = sizeof *q;
    q->data = s->q; /* the model's own array, read anew at each icoray_execute */
    q->type = ICORAY_F64;
    q->location = ICORAY_CENTER;
    q->columns = mesh->cells;
    q->layers = mesh->layers;
    q->column_stride = mesh->layers;
    q->layer_stride = 1;

    (void)(succeeded(&pictures, ranks_open(&config, &pictures.ctx), "icoray_open") &&
           succeeded(&pictures, icoray_grid_set(pictures.ctx, grid), "icoray_grid_set") &&
           succeeded(&pictures, icoray_layers_set(pictures.ctx, &layers), "icoray_layers_set"));
    settle(&pictures); /* what failed on one rank is known to all before the next call that all make together */
    if (pictures.ctx != NULL) {
        (void)succeeded(&pictures, icoray_scene_load(pictures.ctx, options->scene), "icoray_scene_load");
        settle(&pictures);
    }
    pictures.seconds = wall_clock() - start;
    return pictures;
}

/* Every k steps: hands over the tracer and draws the scene from the arrays as they are now. Returns the seconds that it took. */
static double pictures_draw(Pictures *pictures, long step, double time, const char *date)
{
    icoray_frame_report frame = {0};
    double start = wall_clock();
    frame.struct_size = sizeof frame;
    if (pictures->ctx != NULL) {
        /* Here, as models swap time levels: a pointer that is given once shows the step before at every odd step. */
        (void)succeeded(pictures, icoray_field_set(pictures->ctx, "q", &pictures->q), "icoray_field_set");
    }
    if (pictures->ctx != NULL &&
        succeeded(pictures, icoray_execute(pictures->ctx, step, time, date), "icoray_execute") &&
        succeeded(pictures, icoray_report(pictures->ctx, &frame), "icoray_report")) {
        pictures->taken++;
        pictures->prepare += frame.prepare_s;
        pictures->render += frame.render_s;
        pictures->worst = fmax(pictures->worst, frame.error_max);
        pictures->mean += frame.error_mean;
        pictures->p999 = fmax(pictures->p999, frame.error_p999);
        pictures->tolerance = frame.tolerance;
        pictures->estimates += !frame.error_is_bound;
    } else {
        pictures->failed++;
    }
    settle(pictures);
    double seconds = wall_clock() - start;
    pictures->seconds += seconds;
    return seconds;
}

/* Once, after the time loop and before the arrays are freed: waits for the last pictures to be on disk. */
static void pictures_close(Pictures *pictures)
{
    icoray_frame_report frame = {0};
    double start = wall_clock();
    frame.struct_size = sizeof frame;
    if (pictures->ctx != NULL && pictures->taken > 0 &&
        succeeded(pictures, icoray_wait(pictures->ctx), "icoray_wait") &&
        succeeded(pictures, icoray_report(pictures->ctx, &frame), "icoray_report")) {
        pictures->write = frame.write_total_s;
    }
    settle(pictures);
    (void)succeeded(pictures, icoray_close(&pictures->ctx), "icoray_close");
    settle(pictures);
    pictures->seconds += wall_clock() - start;
}

/* Prints the largest errors of the pictures. */
static void print_errors(const Pictures *p)
{
    if (p->taken > 0) {
        printf("pictures' error %.1e at most, %.1e in the mean, 99.9%% of the pixels of each below %.1e;\n", p->worst,
               p->mean / p->taken, p->p999);
        printf("               %s; of a channel from 0 to 1, where %.1e is allowed\n",
               p->estimates > 0 ? "an estimate" : "a bound", p->tolerance);
    }
}

/* ---- the program ---- */

/* Time as a date of a 365-day calendar that starts on 1 January of year 0, to the nearest second. */
static void format_date(double time, char *text, size_t size)
{
    static const int length[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    double whole_seconds = floor(time + 0.5);
    int seconds = (int)fmod(whole_seconds, DAY), days = (int)(whole_seconds / DAY), year = days / 365, month = 0;
    for (days %= 365; days >= length[month]; month++) {
        days -= length[month];
    }
    snprintf(text, size, "%04d-%02d-%02d_%02d:%02d:%02d", year, month + 1, days + 1, seconds / 3600, seconds / 60 % 60,
             seconds % 60);
}

/* Sets the number of steps, and of those between pictures, so that dt is at most the one asked for or allowed. */
static void plan_steps(const Options *o, const Mesh *mesh, const Winds *w, long *steps, long *every)
{
    double dt = o->dt > 0.0 ? o->dt : MAX_COURANT * mesh->shortest / winds_bound(w, mesh->layers);
    double intervals = fmax(1.0, floor(2.0 * o->days + 0.5)); /* of half a day */
    *every = o->every > 0 ? o->every : (long)ceil(o->days * DAY / intervals / dt);
    *steps = o->every > 0 ? (long)ceil(o->days * DAY / dt) : (long)intervals * *every;
}

/* The state's part of a line of the log. */
static void print_state(const Mesh *mesh, const Winds *w, const State *s, long step, double time, double start_mass)
{
    double mass = tracer_mass(mesh, w, s), lowest = s->q[0], highest = s->q[0];
    for (size_t i = 1; i < (size_t)mesh->cells * (size_t)mesh->layers; i++) {
        lowest = fmin(lowest, s->q[i]);
        highest = fmax(highest, s->q[i]);
    }
    printf("%7ld %7.3f %20.13e %10.2e %10.2e %9.6f", step, time / DAY, mass, mass / start_mass - 1.0, lowest, highest);
}

int main(int argc, char **argv)
{
    ranks_start(&argc, &argv);
    Options options = options_from(argc, argv);
    icoray_mesh *generated = NULL;
    icoray_grid grid = {0};
    grid.struct_size = sizeof grid;
    if (icoray_mesh_create(options.level, &generated) != ICORAY_OK || icoray_mesh_grid(generated, &grid) != ICORAY_OK) {
        char message[1024] = "";
        (void)icoray_last_error(NULL, message, sizeof message);
        fprintf(stderr, "tracer: no grid: %s\n", message);
        ranks_finish();
        return EXIT_FAILURE;
    }
    Mesh mesh = mesh_new(&grid, options.layers);
    Winds winds = winds_new(&mesh);
    State state = state_new(&mesh);
    long steps, every;
    plan_steps(&options, &mesh, &winds, &steps, &every);
    double dt = options.days * DAY / (double)steps, start_mass = tracer_mass(&mesh, &winds, &state);

    printf("tracer: %d cells, %d layers, %ld steps of %.3f s, a picture every %ld steps, icoray %s\n", mesh.cells,
           mesh.layers, steps, dt, every, icoray_version());
    printf("   step     day              mass/kg      drift      min q     max q simulate/s visualize/s\n");
    Pictures pictures = pictures_open(&grid, &mesh, &state, &options);
    double simulation = 0.0, shown = 0.0;
    for (long step = 0;; step++) {
        double time = (double)step * dt, start;
        if (step % every == 0 || step == steps) {
            char date[64];
            format_date(time, date, sizeof date);
            print_state(&mesh, &winds, &state, step, time, start_mass);
            printf(" %10.3f %11.3f\n", simulation - shown, pictures_draw(&pictures, step, time, date));
            fflush(stdout);
            shown = simulation;
        }
        if (step == steps) {
            break;
        }
        start = wall_clock();
        advance(&mesh, &winds, &state, time, dt);
        simulation += wall_clock() - start;
    }
    pictures_close(&pictures);

    double drift = tracer_mass(&mesh, &winds, &state) / start_mass - 1.0;
    const char *verdict = fabs(drift) <= DBL_EPSILON * (double)steps ? "conserved to rounding" : "NOT conserved";
    printf("mass           %s, relative drift %.2e\n", verdict, drift);
    if (fabs(options.days * DAY - PERIOD) < 1e-6) {
        printf("l2 error       %.6f against the exact solution\n", l2_error(&mesh, &state));
    }
    printf("simulation     %9.3f s, %.6f s per step, on one thread\n", simulation, simulation / (double)steps);
    printf("visualization  %9.3f s, %.6f s per step; %d pictures: prepare %.3f s, render %.3f s\n", pictures.seconds,
           pictures.seconds / (double)steps, pictures.taken, pictures.prepare, pictures.render);
    printf("writing        %9.3f s beside the simulation\n", pictures.write);
    print_errors(&pictures);
    /* for programs to read */
    printf("summary steps=%ld frames=%d simulation_s=%.6f visualization_s=%.6f mass_drift=%.3e pictures_failed=%d\n",
           steps, pictures.taken, simulation, pictures.seconds, drift, pictures.failed);
    state_free(&state);
    winds_free(&winds);
    mesh_free(&mesh);
    (void)icoray_mesh_free(&generated);
    ranks_finish();
    return pictures.failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
