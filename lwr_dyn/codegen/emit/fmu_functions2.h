/* The functions of FMI 2.0, a part of fmu.c. */
static Status scalars(Instance *m, Refs vr, size_t n, double v[], int set)
{
    size_t i;
    if (!set) refresh(m);
    for (i = 0; i < n; i++) {
        const size_t block = vr[i] / 1000, place = vr[i] % 1000;
        if (block >= BLOCKS || place >= width[block]) return ERR;
        if (set) at(m, (int)block)[place] = v[i];
        else v[i] = at(m, (int)block)[place];
    }
    m->stale |= set;
    return OK;
}

#define F2(name, ...) fmi2Status fmi2##name(__VA_ARGS__)
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
F2(SetDebugLogging, C c, fmi2Boolean on, size_t n, const fmi2String k[]) { return OK; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String place,
                              const fmi2CallbackFunctions *f, fmi2Boolean visible, fmi2Boolean log)
{
    return made(token);
}
void fmi2FreeInstance(C c) { free(c); }
F2(SetupExperiment, C c, fmi2Boolean d, fmi2Real tol, fmi2Real t, fmi2Boolean s, fmi2Real end)
{
    ((Instance *)c)->time = t;
    return OK;
}
F2(EnterInitializationMode, C c) { initialise(c); return OK; }
F2(ExitInitializationMode, C c) { initialise(c); return OK; }
F2(Terminate, C c) { return OK; }
F2(Reset, C c) { return reset(c); }
F2(GetReal, C c, Refs vr, size_t n, fmi2Real v[]) { return scalars(c, vr, n, v, 0); }
F2(SetReal, C c, Refs vr, size_t n, const fmi2Real v[]) { return scalars(c, vr, n, (double *)v, 1); }
#define NONE(name, type) \
    F2(Get##name, C c, Refs vr, size_t n, type v[]) { return n ? ERR : OK; } \
    F2(Set##name, C c, Refs vr, size_t n, const type v[]) { return n ? ERR : OK; }
NONE(Integer, fmi2Integer)
NONE(Boolean, fmi2Boolean)
NONE(String, fmi2String)
F2(GetFMUstate, C c, fmi2FMUstate *s) { return copy_state(c, s); }
F2(SetFMUstate, C c, fmi2FMUstate s) { memcpy(c, s, sizeof(Instance)); return OK; }
F2(FreeFMUstate, C c, fmi2FMUstate *s) { free(*s); *s = NULL; return OK; }
F2(SerializedFMUstateSize, C c, fmi2FMUstate s, size_t *n) { *n = sizeof(Instance); return OK; }
F2(SerializeFMUstate, C c, fmi2FMUstate s, fmi2Byte b[], size_t n)
{
    if (n < sizeof(Instance)) return ERR;
    memcpy(b, s, sizeof(Instance));
    return OK;
}
F2(DeSerializeFMUstate, C c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
{
    if (n < sizeof(Instance) || copy_state(c, s)) return ERR;
    memcpy(*s, b, sizeof(Instance));
    return OK;
}
F2(GetDirectionalDerivative, C c, Refs u, size_t nu, Refs k, size_t nk, const fmi2Real d[], fmi2Real o[])
{
    return directional(c, u, nu, k, nk, d, nk, o, nu);
}
F2(EnterEventMode, C c) { return OK; }
F2(NewDiscreteStates, C c, fmi2EventInfo *e) { memset(e, 0, sizeof *e); return OK; }
F2(EnterContinuousTimeMode, C c) { return OK; }
F2(CompletedIntegratorStep, C c, fmi2Boolean p, fmi2Boolean *e, fmi2Boolean *t) { *e = 0; *t = 0; return OK; }
F2(SetTime, C c, fmi2Real t) { ((Instance *)c)->time = t; return OK; }
F2(GetEventIndicators, C c, fmi2Real v[], size_t n) { return n ? ERR : OK; }
F2(SetRealInputDerivatives, C c, Refs vr, size_t n, const fmi2Integer o[], const fmi2Real v[]) { return ERR; }
F2(GetRealOutputDerivatives, C c, Refs vr, size_t n, const fmi2Integer o[], fmi2Real v[]) { return ERR; }
F2(DoStep, C c, fmi2Real t, fmi2Real h, fmi2Boolean keep) { return advance(c, t, h); }
F2(CancelStep, C c) { return ERR; }
#define STATUS(name, type) F2(Get##name##Status, C c, const fmi2StatusKind k, type *v) { return ERR; }
STATUS(, fmi2Status)
STATUS(Real, fmi2Real)
STATUS(Integer, fmi2Integer)
STATUS(Boolean, fmi2Boolean)
STATUS(String, fmi2String)
F2(GetContinuousStates, C c, fmi2Real x[], size_t n) { return states(c, Q_STATE, x, n, 0); }
F2(SetContinuousStates, C c, const fmi2Real x[], size_t n) { return states(c, Q_STATE, (double *)x, n, 1); }
F2(GetDerivatives, C c, fmi2Real x[], size_t n) { return states(c, RATES, x, n, 0); }
F2(GetNominalsOfContinuousStates, C c, fmi2Real x[], size_t n) { return ones(x, n); }
