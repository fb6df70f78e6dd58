/* samples start to stop of one run; the block keeps the state between two calls */
int run(const double *common, int common_size, const double *reference, int samples, double *out, double *b, int start,
        int stop)
{
    if (start == 0) {
        for (int j = 0; j < SIZE; j++) {
            b[j] = common[j];
        }
    }
    for (int i = start; i < stop; i++) {
        for (int j = 0; j < ROW; j++) {
            b[REFERENCE + j] = reference[i * ROW + j];
        }
        b[SAMPLE] = i;
        before(b, out, samples, i);
        step(b, 0, 0, i);
        after(b, out, samples, i);
    }
    return 0;
}
