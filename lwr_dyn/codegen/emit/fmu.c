/* An arm as a plant, or a control law at samples, behind the functions of FMI 2.0 and 3.0.
 *
 * fmu_config.h says which: N joints, BLOCKS of variables with their places in `value`, START, TOKEN, and the names of
 * the arm's functions. A value reference is the number of a block in FMI 3, and block * 1000 + place in FMI 2.
 * Importers load every function of the standard, so those that are not supported are here too, and say so.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmu_config.h"
#if FMI == 2
#include "fmi2Functions.h"
typedef fmi2Status Status;
enum { OK = fmi2OK, ERR = fmi2Error };
#else
#include "fmi3Functions.h"
typedef fmi3Status Status;
enum { OK = fmi3OK, ERR = fmi3Error };
#endif

typedef struct {
    double time;
    double value[SIZE];
    int stale; /* whether outputs belong to older states or inputs */
} Instance;

static const double start[SIZE] = START;

static double *at(Instance *m, int block)
{
    return m->value + offset[block];
}

static int all_finite(const double *x, int count)
{
    int i;
    for (i = 0; i < count; i++) {
        if (!isfinite(x[i])) return 0;
    }
    return 1;
}

#ifdef PLANT
enum { STATES = 2 * N };

/* (m, m c, Ixx Ixy Iyy Ixz Iyz Izz about the flange) of a load given by mass, centre and inertia about it */
static void load_of(Instance *m, double out[10])
{
    const double mass = *at(m, PAYLOAD_MASS), *c = at(m, PAYLOAD_COM), *i = at(m, PAYLOAD_INERTIA);
    const double xx = c[0] * c[0], yy = c[1] * c[1], zz = c[2] * c[2];
    out[0] = mass;
    out[1] = mass * c[0];
    out[2] = mass * c[1];
    out[3] = mass * c[2];
    out[4] = i[0] + mass * (yy + zz);
    out[5] = i[1] - mass * c[0] * c[1];
    out[6] = i[3] + mass * (xx + zz);
    out[7] = i[2] - mass * c[0] * c[2];
    out[8] = i[4] - mass * c[1] * c[2];
    out[9] = i[5] + mass * (xx + yy);
}

/* What moves the arm: the torques up to their limits, less friction. */
static void net_torque(Instance *m, const double *dq, double tau[N])
{
    int i;
#ifdef FRICTION
    double loss[N];
    ARM(smooth_friction_torque)(dq, at(m, FRICTION_WIDTH), loss);
#endif
    for (i = 0; i < N; i++) {
        const double limit = at(m, TORQUE_LIMIT)[i], given = at(m, TAU)[i];
        tau[i] = given > limit ? limit : given < -limit ? -limit : given;
#ifdef FRICTION
        tau[i] -= *at(m, FRICTION_SCALE) * loss[i];
#endif
    }
}

static void accelerations(Instance *m, const double *q, const double *dq, double *ddq)
{
    double tau[N], load[10];
    net_torque(m, dq, tau);
    load_of(m, load);
    ARM(forward_dynamics)(q, dq, tau, load, at(m, GRAVITY), ddq);
}

/* The derivatives of what is computed from states and torques, along `seed`; a torque at its limit does not count. */
static void tangent(Instance *m, const double seed[SIZE], double out[SIZE])
{
    const double *q = at(m, Q), *dq = at(m, DQ), *vq = seed + offset[Q], *vdq = seed + offset[DQ];
    double tau[N], along[N], load[10];
    int i;
#ifdef FRICTION
    double loss[N];
    ARM(smooth_friction_torque_tangent)(dq, at(m, FRICTION_WIDTH), vdq, loss);
#endif
    for (i = 0; i < N; i++) {
        along[i] = fabs(at(m, TAU)[i]) < at(m, TORQUE_LIMIT)[i] ? seed[offset[TAU] + i] : 0.0;
#ifdef FRICTION
        along[i] -= *at(m, FRICTION_SCALE) * loss[i];
#endif
    }
    net_torque(m, dq, tau);
    load_of(m, load);
    memcpy(out + offset[Q], vq, N * sizeof(double));
    memcpy(out + offset[DQ], vdq, N * sizeof(double));
    memcpy(out + offset[DER_Q], vdq, N * sizeof(double));
    ARM(forward_dynamics_tangent)(q, dq, tau, load, at(m, GRAVITY), vq, vdq, along, out + offset[DDQ]);
    ARM(flange_pose_tangent)(q, vq, out + offset[TIP]);
}

/* Where the seed of a variable counts, as a block; -1 for one in whose direction nothing is differentiated. */
static int moved(int block)
{
    if (block == Q_START) return Q;
    if (block == DQ_START) return DQ;
    return block == Q || block == DQ || block == TAU ? block : -1;
}

static int follows(int block)
{
    return block == Q || block == DQ || block == DER_Q || block == DDQ || block == TIP;
}

static void refresh(Instance *m)
{
    if (!m->stale) return;
    memcpy(at(m, DER_Q), at(m, DQ), N * sizeof(double));
    accelerations(m, at(m, Q), at(m, DQ), at(m, DDQ));
    ARM(flange_pose)(at(m, Q), at(m, TIP));
    m->stale = 0;
}

static void runge_kutta(Instance *m, double h)
{
    static const double node[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double x[STATES], y[STATES], slope[STATES] = {0.0}, sum[STATES] = {0.0};
    int stage, i;
    memcpy(x, at(m, Q), sizeof x); /* DQ follows Q */
    for (stage = 0; stage < 4; stage++) {
        for (i = 0; i < STATES; i++) y[i] = x[i] + h * node[stage] * slope[i];
        memcpy(slope, y + N, N * sizeof(double));
        accelerations(m, y, y + N, slope + N);
        for (i = 0; i < STATES; i++) sum[i] += weight[stage] * slope[i];
    }
    for (i = 0; i < STATES; i++) at(m, Q)[i] = x[i] + h / 6.0 * sum[i];
}

static Status advance(Instance *m, double t, double h)
{
    const double largest = *at(m, STEP);
    long count, k;
    if (!(h > 0.0 && largest > 0.0 && h / largest < 1e9)) return ERR;
    count = (long)ceil(h / largest - 1e-9);
    count = count < 1 ? 1 : count;
    for (k = 0; k < count; k++) runge_kutta(m, h / (double)count);
    m->time = t + h;
    m->stale = 1;
    return all_finite(at(m, Q), STATES) ? OK : ERR;
}

static void initialise(Instance *m)
{
    memcpy(at(m, Q), at(m, Q_START), N * sizeof(double));
    memcpy(at(m, DQ), at(m, DQ_START), N * sizeof(double));
    m->stale = 1;
}
#else
enum { STATES = 0, Q_STATE = 0, RATES = 0 };

static void refresh(Instance *m)
{
    m->stale = 0;
}

/* The law at a sample; its memory moves on only where a step does. */
static Status sample(Instance *m, double h, int moves)
{
    double out[N + MEMORY];
    LAW(m, h, out);
    memcpy(at(m, TAU_VALUE), out, N * sizeof(double));
#if MEMORY > 0
    if (moves) memcpy(at(m, MEMORY_VALUE), out + N, MEMORY * sizeof(double));
#endif
    (void)moves;
    return all_finite(out, N) ? OK : ERR;
}

static Status advance(Instance *m, double t, double h)
{
    m->time = t + h;
    return h > 0.0 ? sample(m, h, 1) : ERR;
}

static void initialise(Instance *m)
{
    sample(m, SAMPLE_TIME, 0);
}

static void tangent(Instance *m, const double seed[SIZE], double out[SIZE]) { (void)m, (void)seed, (void)out; }
static int moved(int block) { return (void)block, -1; }
static int follows(int block) { return (void)block, 0; }
#endif
#ifdef PLANT
enum { Q_STATE = Q, RATES = DER_Q };
#endif

static Instance *made(const char *token)
{
    Instance *m = token && !strcmp(token, TOKEN) ? calloc(1, sizeof *m) : NULL;
    if (m) {
        memcpy(m->value, start, sizeof start);
        m->stale = 1;
    }
    return m;
}

static Status reset(Instance *m)
{
    memcpy(m->value, start, sizeof start);
    m->time = 0.0;
    m->stale = 1;
    return OK;
}

static Status copy_state(Instance *m, void **state)
{
    if (!*state) *state = malloc(sizeof *m);
    if (!*state) return ERR;
    memcpy(*state, m, sizeof *m);
    return OK;
}

static Status states(Instance *m, int block, double x[], size_t count, int set)
{
    if (count != (size_t)STATES) return ERR;
    if (block == RATES && !set) refresh(m);
    if (set) memcpy(at(m, block), x, count * sizeof(double));
    else memcpy(x, at(m, block), count * sizeof(double));
    m->stale |= set;
    return OK;
}

static Status ones(double x[], size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) x[i] = 1.0;
    return OK;
}

#if FMI == 2
typedef fmi2Component C;
typedef const fmi2ValueReference *Refs;
enum { PLACES = 1000 };
#else
typedef fmi3Instance C;
typedef const fmi3ValueReference *Refs;
enum { PLACES = 1 };
#endif

/* The block of a value reference, with the first number and how many it means; -1 for a reference that is none. */
static int block_of(unsigned long reference, size_t *first, size_t *count)
{
    const size_t block = reference / PLACES;
    *first = reference % PLACES;
    if (block >= BLOCKS || *first >= width[block]) return -1;
    *count = PLACES > 1 ? 1 : width[block];
    return (int)block;
}

static Status directional(Instance *m, Refs unknown, size_t unknowns, Refs known, size_t knowns, const double *seed,
                          size_t seeds, double *out, size_t outs)
{
    double given[SIZE] = {0.0}, found[SIZE] = {0.0};
    size_t i, k, first, count = 0, used = 0;
    for (i = 0; i < knowns; i++, used += count) {
        const int block = block_of(known[i], &first, &count), to = block < 0 ? -1 : moved(block);
        if (to < 0 || used + count > seeds) return ERR;
        for (k = 0; k < count; k++) given[offset[to] + first + k] += seed[used + k];
    }
    if (used != seeds) return ERR;
    tangent(m, given, found);
    for (i = 0, used = 0; i < unknowns; i++, used += count) {
        const int block = block_of(unknown[i], &first, &count);
        if (block < 0 || !follows(block) || used + count > outs) return ERR;
        memcpy(out + used, found + offset[block] + first, count * sizeof(double));
    }
    return used == outs ? OK : ERR;
}

#if FMI == 2
#include "fmu_functions2.h"
#else
#include "fmu_functions3.h"
#endif
