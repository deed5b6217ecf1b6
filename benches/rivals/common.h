/* What the C rivals share: the matrix file, clocks, medians, the residual. See benches/solvers.rs. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { RUNS = 5, MANY = 8 };

/* Lower triangle of K by columns, rows ascending, the diagonal first. */
typedef struct {
    int64_t n, entries;
    int32_t *start, *row;
    double *value;
} Matrix;

static void *take(FILE *file, size_t size, size_t count) {
    void *data = malloc(size * count + 1);
    if (!data || fread(data, size, count, file) != count) {
        fprintf(stderr, "the matrix file is short\n");
        exit(1);
    }
    return data;
}

static Matrix read_matrix(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        perror(path);
        exit(1);
    }
    Matrix k;
    int64_t *size = take(file, 8, 2);
    k.n = size[0];
    k.entries = size[1];
    free(size);
    k.start = take(file, 4, k.n + 1);
    k.row = take(file, 4, k.entries);
    k.value = take(file, 8, k.entries);
    fclose(file);
    return k;
}

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *times, int runs) {
    qsort(times, runs, sizeof(double), by_value);
    return times[runs / 2];
}

/* NAME wall processor: medians of RUNS after one that is not counted. */
#define MEASURE(name, runs, work)                                                              \
    do {                                                                                       \
        double wall_[RUNS], cpu_[RUNS];                                                        \
        for (int run_ = -((runs) > 1); run_ < (runs); run_++) {                                \
            double w_ = seconds(CLOCK_MONOTONIC), c_ = seconds(CLOCK_PROCESS_CPUTIME_ID);      \
            work;                                                                              \
            if (run_ < 0) continue;                                                            \
            wall_[run_] = seconds(CLOCK_MONOTONIC) - w_;                                          \
            cpu_[run_] = seconds(CLOCK_PROCESS_CPUTIME_ID) - c_;                                  \
        }                                                                                      \
        printf("%s %.6f %.6f\n", name, median(wall_, (runs)), median(cpu_, (runs)));             \
    } while (0)

/* The right-hand sides: the same in all programs. */
static double load(int64_t dof, int64_t column) { return 1.0 + (double)((dof * 7 + column) % 13); }

/* The largest residual |K x - b| / |b| of the columns. */
static double residual(const Matrix *k, const double *x, int columns) {
    double worst = 0;
    double *r = malloc(8 * k->n);
    for (int c = 0; c < columns; c++, x += k->n) {
        double size = 0, rest = 0;
        for (int64_t i = 0; i < k->n; i++) size += load(i, c) * load(i, c), r[i] = load(i, c);
        for (int64_t j = 0; j < k->n; j++)
            for (int32_t p = k->start[j]; p < k->start[j + 1]; p++) {
                int32_t i = k->row[p];
                r[i] -= k->value[p] * x[j];
                if (i != j) r[j] -= k->value[p] * x[i];
            }
        for (int64_t i = 0; i < k->n; i++) rest += r[i] * r[i];
        worst = fmax(worst, sqrt(rest / size));
    }
    free(r);
    return worst;
}
