/* Runs a scene through the library and compares it, bit by bit, with the CSV file that `nutate run` has written: as a
 * whole, and step by step.   same_bits SCENE CSV */
#include <nutate.h>
#include <stdio.h>
#include <stdlib.h>

/* Reads the numbers of a CSV file with one header row: how many there are. */
static size_t read_numbers(const char *path, double *values, size_t room)
{
    FILE *file = fopen(path, "r");
    size_t n = 0;
    int byte;
    if (!file) return 0;
    do byte = fgetc(file);
    while (byte != '\n' && byte != EOF);
    while (n < room && fscanf(file, "%lf", &values[n]) == 1) {
        ++n;
        byte = fgetc(file); /* comma or end of line */
    }
    fclose(file);
    return n;
}

static size_t count_differences(const double *a, const double *b, size_t n)
{
    size_t i, differences = 0;
    for (i = 0; i < n; ++i) differences += a[i] != b[i];
    return differences;
}

int main(int argc, char **argv)
{
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    nutate_stepper *stepper = NULL;
    char message[512] = "";
    size_t rows, columns, width, n, done, whole, stepped;
    double *csv, *run, *steps, time_step, end_time;
    int64_t every;
    int status;

    if (argc != 3) {
        fprintf(stderr, "same_bits SCENE CSV\n");
        return 2;
    }
    status = nutate_scene_read(argv[1], NULL, 0, &scene, message, sizeof message);
    if (!status) status = nutate_scene_run(scene, &history, message, sizeof message);
    if (!status) status = nutate_stepper_create_scene(scene, &stepper, message, sizeof message);
    if (!status) status = nutate_history_size(history, &rows, &columns);
    if (!status) status = nutate_stepper_width(stepper, &width);
    if (!status) status = nutate_scene_get_plan(scene, &time_step, &end_time, &every);
    if (status) {
        fprintf(stderr, "same_bits: %s\n", message);
        return status;
    }
    n = rows * columns;
    csv = malloc((n + 1) * sizeof *csv);
    run = malloc(n * sizeof *run);
    steps = malloc(n * sizeof *steps);
    if (!csv || !run || !steps || width != columns || read_numbers(argv[2], csv, n + 1) != n) {
        fprintf(stderr, "same_bits: %s has not %zu rows of %zu columns\n", argv[2], rows, columns);
        return 1;
    }
    status = nutate_history_values(history, run, n);
    /* The first state, then batches of one row each: the state of the run stays in the stepper between calls. */
    if (!status) status = nutate_stepper_row(stepper, steps, width);
    for (done = 1; done + 1 < rows && !status; ++done)
        status = nutate_stepper_run(stepper, every, every, steps + done * width, 1, NULL);
    if (!status) status = nutate_stepper_run_to(stepper, end_time, every, 0.0, NULL, 0, NULL);
    if (!status) status = nutate_stepper_row(stepper, steps + done * width, width);
    whole = count_differences(run, csv, n);
    stepped = count_differences(steps, csv, n);
    printf("%s: %zu rows of %zu columns; differences from the CSV file: %zu as a whole, %zu step by step\n", argv[1], rows,
           columns, whole, stepped);
    free(csv);
    free(run);
    free(steps);
    nutate_stepper_destroy(&stepper);
    nutate_history_destroy(&history);
    nutate_scene_destroy(&scene);
    return status ? status : whole + stepped > 0;
}
