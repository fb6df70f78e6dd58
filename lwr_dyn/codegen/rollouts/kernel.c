/* runs start to stop, blocks of W lanes; their figures go to rows of `out`, and what is recorded and traced */
int rollouts(const double *common, int is_traced, const double *given, int values, const double *places, int samples,
             const double *reference, int references, const double *which, int stride, double *record, int kept,
             double *trace, int trace_step, int seed, int first_run, double *out, double *b, int start, int stop)
{
    for (int s = start; s < stop; s += W) {
        const int lanes = W < stop - s ? W : stop - s;
        for (int j = 0; j < SIZE; j++) {
            const double x = common[j];
            for (int k = 0; k < W; k++) {
                b[j * W + k] = x;
            }
        }
        for (int j = 0; j < values; j++) {
            const int place = (int)places[j] * W;
            for (int k = 0; k < W; k++) {
                b[place + k] = given[(s + k < stop ? s + k : stop - 1) * values + j];
            }
        }
        for (int i = 0; i < samples; i++) {
            if (references == 1) {
                for (int j = 0; j < ROW; j++) {
                    const double x = reference[i * ROW + j];
                    for (int k = 0; k < W; k++) {
                        b[(REFERENCE + j) * W + k] = x;
                    }
                }
            } else {
                for (int k = 0; k < W; k++) {
                    const int row = ((int)which[s + k < stop ? s + k : stop - 1] * samples + i) * ROW;
                    for (int j = 0; j < ROW; j++) {
                        b[(REFERENCE + j) * W + k] = reference[row + j];
                    }
                }
            }
            const double sample = i;
            for (int k = 0; k < W; k++) {
                b[SAMPLE * W + k] = sample;
            }
            const int at = i / stride;
            if (kept != 0 && i % stride == 0) {
                for (int k = 0; k < lanes; k++) {
                    for (int j = 0; j < 2 * N; j++) {
                        record[((s + k) * kept + at) * 3 * N + j] = b[j * W + k];
                    }
                }
            }
            step(b, seed, first_run + s, i);
            if (kept != 0 && i % stride == 0) {
                for (int k = 0; k < lanes; k++) {
                    for (int j = 0; j < N; j++) {
                        record[((s + k) * kept + at) * 3 * N + 2 * N + j] = b[(APPLIED + j) * W + k];
                    }
                }
            }
            if (is_traced != 0) {
                for (int k = 0; k < lanes; k++) {
                    trace[(s - start + k) * samples + i] = b[TIP_SQUARE * W + k];
                }
            }
        }
        for (int k = 0; k < lanes; k++) {
            for (int j = 0; j < FIGURES; j++) {
                out[(s + k) * FIGURES + j] = b[(FIRST_FIGURE + j) * W + k];
            }
        }
    }
    return 0;
}
