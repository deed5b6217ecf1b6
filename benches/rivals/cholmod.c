/* CHOLMOD with METIS: cholmod FILE. Threads: OMP_NUM_THREADS, OPENBLAS_NUM_THREADS. */
#include "common.h"
#include <cholmod.h>

static cholmod_dense *loads(const Matrix *k, int columns, cholmod_common *c) {
    cholmod_dense *b = cholmod_allocate_dense(k->n, columns, k->n, CHOLMOD_REAL, c);
    for (int j = 0; j < columns; j++)
        for (int64_t i = 0; i < k->n; i++) ((double *)b->x)[j * k->n + i] = load(i, j);
    return b;
}

int main(int count, char **arguments) {
    if (count != 2) return 2;
    Matrix k = read_matrix(arguments[1]);
    cholmod_common c;
    cholmod_start(&c);
    c.nmethods = 1;
    c.method[0].ordering = CHOLMOD_METIS;
    c.postorder = 1;
    c.supernodal = CHOLMOD_SUPERNODAL;
    cholmod_sparse a = {.nrow = k.n, .ncol = k.n, .nzmax = k.entries, .p = k.start, .i = k.row,
                        .x = k.value, .stype = -1, .itype = CHOLMOD_INT, .xtype = CHOLMOD_REAL,
                        .dtype = CHOLMOD_DOUBLE, .sorted = 1, .packed = 1};
    cholmod_factor *l = NULL;
    MEASURE("analysis", 1, l = cholmod_analyze(&a, &c));
    if (!l) return 1;
    MEASURE("numeric", RUNS, cholmod_factorize(&a, l, &c));
    if (c.status != CHOLMOD_OK) return 1;
    cholmod_dense *x = NULL, *y = NULL, *e = NULL;
    for (int columns = 1; columns <= MANY; columns += MANY - 1) {
        cholmod_dense *b = loads(&k, columns, &c);
        MEASURE(columns == 1 ? "solve" : "solve8", RUNS,
                cholmod_solve2(CHOLMOD_A, l, b, NULL, &x, NULL, &y, &e, &c));
        printf("residual %.3e\n", residual(&k, x->x, columns));
    }
    printf("entries %.0f\nflops %.6e\n", (double)l->xsize, c.fl);
    return 0;
}
