/* The law of inverse dynamics at 1 kHz on an LWR 4+ with 2 kg that the law does not know, beside the run in Python.
 * lwr-dyn kernels lwr4plus --language c --emit step_inverse_dynamics,forward_dynamics --inputs payload --out lwr4plus.c
 * cc -O2 -std=c99 -I. control_loop.c lwr4plus.c -lm -o control_loop && ./control_loop < run.csv */
#include "lwr4plus.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { N = 7, STEPS = 1000, TORQUE = 1 + 4 * N }; /* in the run's table, after time, q, dq, q_ref, dq_ref */
static const double H = 0.001, TURN = 3.141592653589793 / 180.0, payload[10] = {2.0};
static const double from[N] = {0, 30, 0, -70, 0, 35, 0}, to[N] = {40, 60, -20, -20, 30, 60, 10}; /* deg */

static void rates(const double x[2 * N], const double tau[N], double out[2 * N])
{
    memcpy(out, x + N, N * sizeof *out);
    lwr4plus_forward_dynamics(x, x + N, tau, payload, out + N);
}

static void advance(double x[2 * N], const double tau[N]) /* Runge-Kutta of order 4, the torque held */
{
    static const double node[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double k[2 * N] = {0.0}, sum[2 * N] = {0.0}, y[2 * N];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < 2 * N; i++) y[i] = x[i] + node[stage] * H * k[i];
        rates(y, tau, k);
        for (int i = 0; i < 2 * N; i++) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < 2 * N; i++) x[i] += H / 6.0 * sum[i];
}

int main(void)
{
    double x[2 * N] = {0.0}, q_ref[N], dq_ref[N], ddq_ref[N], tau[N], Kp[N], Kd[N], worst[2] = {0.0, 0.0};
    char line[4096];
    for (int i = 0; i < N; i++) x[i] = from[i] * TURN, Kp[i] = 2500.0, Kd[i] = 100.0;
    if (!fgets(line, sizeof line, stdin)) return 2; /* names of columns */
    for (int k = 0; k <= STEPS; k++) {
        const double u = k * H, s = u * u * u * (10.0 + u * (6.0 * u - 15.0)); /* a quintic of one second */
        const double ds = 30.0 * u * u * (1.0 - u) * (1.0 - u), dds = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        for (int i = 0; i < N; i++) {
            const double way = (to[i] - from[i]) * TURN;
            q_ref[i] = from[i] * TURN + way * s, dq_ref[i] = way * ds, ddq_ref[i] = way * dds;
        }
        lwr4plus_step_inverse_dynamics(x, x + N, q_ref, dq_ref, ddq_ref, Kp, Kd, tau);
        if (!fgets(line, sizeof line, stdin)) return 2;
        char *at = line; /* the same sample of the run */
        for (int c = 0; c < TORQUE + N; c++) {
            const double said = strtod(at, &at);
            if (*at++ != ',') return 2; /* a number and a comma */
            if (c >= 1 && c <= N) worst[0] = fmax(worst[0], fabs(x[c - 1] - said));
            if (c >= TORQUE) worst[1] = fmax(worst[1], fabs(tau[c - TORQUE] - said));
        }
        advance(x, tau);
    }
    printf("largest difference from the run in Python: %.0e rad, %.0e N m\n", worst[0], worst[1]);
    return !(worst[0] < 1e-9 && worst[1] < 1e-9);
}
