/* MUMPS (sequential build) with METIS: mumps FILE. Threads: OMP_NUM_THREADS, OPENBLAS_NUM_THREADS. */
#include "common.h"
#include <dmumps_c.h>

static void run(DMUMPS_STRUC_C *id, int job) {
    id->job = job;
    dmumps_c(id);
    if (id->infog[0] < 0) {
        fprintf(stderr, "MUMPS: INFOG(1) = %d, INFOG(2) = %d\n", id->infog[0], id->infog[1]);
        exit(1);
    }
}

static void fill(const Matrix *k, double *x, int columns) {
    for (int j = 0; j < columns; j++)
        for (int64_t i = 0; i < k->n; i++) x[j * k->n + i] = load(i, j);
}

int main(int count, char **arguments) {
    if (count != 2) return 2;
    Matrix k = read_matrix(arguments[1]);
    MUMPS_INT *row = malloc(4 * k.entries), *column = malloc(4 * k.entries);
    for (int64_t j = 0; j < k.n; j++)
        for (int32_t p = k.start[j]; p < k.start[j + 1]; p++) {
            row[p] = k.row[p] + 1;
            column[p] = j + 1;
        }
    DMUMPS_STRUC_C id = {.par = 1, .sym = 1, .comm_fortran = -987654};
    run(&id, -1);
    id.icntl[0] = id.icntl[1] = id.icntl[2] = -1;
    id.icntl[3] = 0;
    id.icntl[6] = 5; /* METIS */
    id.icntl[13] = 50; /* per cent of working memory more than estimated */
    id.n = k.n;
    id.nnz = k.entries;
    id.irn = row;
    id.jcn = column;
    id.a = k.value;
    MEASURE("analysis", 1, run(&id, 1));
    MEASURE("numeric", RUNS, run(&id, 2));
    double *x = malloc(8 * k.n * MANY), *b = malloc(8 * k.n * MANY);
    fill(&k, b, MANY);
    id.rhs = x;
    id.lrhs = k.n;
    id.icntl[26] = MANY; /* right-hand sides at a time */
    for (int columns = 1; columns <= MANY; columns += MANY - 1) {
        id.nrhs = columns;
        MEASURE(columns == 1 ? "solve" : "solve8", RUNS, (memcpy(x, b, 8 * k.n * columns), run(&id, 3)));
        printf("residual %.3e\n", residual(&k, x, columns));
    }
    printf("entries %.0f\nflops %.6e\n", (double)id.infog[28], id.rinfog[2]);
    run(&id, -2);
    return 0;
}
