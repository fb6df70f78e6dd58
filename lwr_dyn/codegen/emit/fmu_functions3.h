/* The functions of FMI 3.0, a part of fmu.c. */
static Status arrays(Instance *m, Refs vr, size_t n, double v[], size_t numbers, int set)
{
    size_t i, k = 0;
    if (!set) refresh(m);
    for (i = 0; i < n; i++) {
        const size_t count = vr[i] == BLOCKS ? 1 : vr[i] < BLOCKS ? width[vr[i]] : 0;
        double *x = vr[i] == BLOCKS ? &m->time : at(m, (int)vr[i]);
        if (!count || k + count > numbers || (set && vr[i] == BLOCKS)) return ERR;
        if (set) memcpy(x, v + k, count * sizeof(double));
        else memcpy(v + k, x, count * sizeof(double));
        k += count;
    }
    m->stale |= set;
    return k == numbers ? OK : ERR;
}

#define F3(name, ...) fmi3Status fmi3##name(__VA_ARGS__)
const char *fmi3GetVersion(void) { return fmi3Version; }
F3(SetDebugLogging, C c, fmi3Boolean on, size_t n, const fmi3String k[]) { return OK; }
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean v,
                                          fmi3Boolean l, fmi3InstanceEnvironment e, fmi3LogMessageCallback f)
{
    return made(token);
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean v,
                                         fmi3Boolean l, fmi3Boolean events, fmi3Boolean early, Refs needed, size_t n,
                                         fmi3InstanceEnvironment e, fmi3LogMessageCallback f,
                                         fmi3IntermediateUpdateCallback u)
{
    return made(token);
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean v,
                                               fmi3Boolean l, fmi3InstanceEnvironment e, fmi3LogMessageCallback f,
                                               fmi3ClockUpdateCallback u, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    return NULL;
}
void fmi3FreeInstance(C c) { free(c); }
F3(EnterInitializationMode, C c, fmi3Boolean d, fmi3Float64 tol, fmi3Float64 t, fmi3Boolean s, fmi3Float64 end)
{
    ((Instance *)c)->time = t;
    initialise(c);
    return OK;
}
F3(ExitInitializationMode, C c) { initialise(c); return OK; }
F3(Terminate, C c) { return OK; }
F3(Reset, C c) { return reset(c); }
F3(GetFloat64, C c, Refs vr, size_t n, fmi3Float64 v[], size_t k) { return arrays(c, vr, n, v, k, 0); }
F3(SetFloat64, C c, Refs vr, size_t n, const fmi3Float64 v[], size_t k) { return arrays(c, vr, n, (double *)v, k, 1); }
#define NONE(name) \
    F3(Get##name, C c, Refs vr, size_t n, fmi3##name v[], size_t k) { return n ? ERR : OK; } \
    F3(Set##name, C c, Refs vr, size_t n, const fmi3##name v[], size_t k) { return n ? ERR : OK; }
NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(Int32)
NONE(UInt32)
NONE(Int64)
NONE(UInt64)
NONE(Boolean)
NONE(String)
F3(GetBinary, C c, Refs vr, size_t n, size_t s[], fmi3Binary v[], size_t k) { return n ? ERR : OK; }
F3(SetBinary, C c, Refs vr, size_t n, const size_t s[], const fmi3Binary v[], size_t k) { return n ? ERR : OK; }
F3(GetClock, C c, Refs vr, size_t n, fmi3Clock v[]) { return n ? ERR : OK; }
F3(SetClock, C c, Refs vr, size_t n, const fmi3Clock v[]) { return n ? ERR : OK; }
F3(GetNumberOfVariableDependencies, C c, fmi3ValueReference vr, size_t *n) { return ERR; }
F3(GetVariableDependencies, C c, fmi3ValueReference of, size_t e[], fmi3ValueReference on[], size_t i[],
   fmi3DependencyKind kinds[], size_t n)
{
    return ERR;
}
F3(GetFMUState, C c, fmi3FMUState *s) { return copy_state(c, s); }
F3(SetFMUState, C c, fmi3FMUState s) { memcpy(c, s, sizeof(Instance)); return OK; }
F3(FreeFMUState, C c, fmi3FMUState *s) { free(*s); *s = NULL; return OK; }
F3(SerializedFMUStateSize, C c, fmi3FMUState s, size_t *n) { *n = sizeof(Instance); return OK; }
F3(SerializeFMUState, C c, fmi3FMUState s, fmi3Byte b[], size_t n)
{
    if (n < sizeof(Instance)) return ERR;
    memcpy(b, s, sizeof(Instance));
    return OK;
}
F3(DeserializeFMUState, C c, const fmi3Byte b[], size_t n, fmi3FMUState *s)
{
    if (n < sizeof(Instance) || copy_state(c, s)) return ERR;
    memcpy(*s, b, sizeof(Instance));
    return OK;
}
F3(GetDirectionalDerivative, C c, Refs u, size_t nu, Refs k, size_t nk, const fmi3Float64 s[], size_t ns,
   fmi3Float64 o[], size_t no)
{
    return directional(c, u, nu, k, nk, s, ns, o, no);
}
F3(GetAdjointDerivative, C c, Refs u, size_t nu, Refs k, size_t nk, const fmi3Float64 s[], size_t ns,
   fmi3Float64 o[], size_t no)
{
    return ERR;
}
#define PLAIN(name) F3(name, C c) { return OK; }
PLAIN(EnterConfigurationMode)
PLAIN(ExitConfigurationMode)
PLAIN(EvaluateDiscreteStates)
PLAIN(EnterEventMode)
PLAIN(EnterContinuousTimeMode)
PLAIN(EnterStepMode)
F3(GetIntervalDecimal, C c, Refs vr, size_t n, fmi3Float64 i[], fmi3IntervalQualifier q[]) { return ERR; }
F3(GetIntervalFraction, C c, Refs vr, size_t n, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier q[]) { return ERR; }
F3(GetShiftDecimal, C c, Refs vr, size_t n, fmi3Float64 s[]) { return ERR; }
F3(GetShiftFraction, C c, Refs vr, size_t n, fmi3UInt64 a[], fmi3UInt64 b[]) { return ERR; }
F3(SetIntervalDecimal, C c, Refs vr, size_t n, const fmi3Float64 i[]) { return ERR; }
F3(SetIntervalFraction, C c, Refs vr, size_t n, const fmi3UInt64 a[], const fmi3UInt64 b[]) { return ERR; }
F3(SetShiftDecimal, C c, Refs vr, size_t n, const fmi3Float64 s[]) { return ERR; }
F3(SetShiftFraction, C c, Refs vr, size_t n, const fmi3UInt64 a[], const fmi3UInt64 b[]) { return ERR; }
F3(UpdateDiscreteStates, C c, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals, fmi3Boolean *values,
   fmi3Boolean *defined, fmi3Float64 *next)
{
    *again = *ends = *nominals = *values = *defined = fmi3False;
    *next = 0.0;
    return OK;
}
F3(CompletedIntegratorStep, C c, fmi3Boolean p, fmi3Boolean *e, fmi3Boolean *t) { *e = *t = fmi3False; return OK; }
F3(SetTime, C c, fmi3Float64 t) { ((Instance *)c)->time = t; return OK; }
F3(GetEventIndicators, C c, fmi3Float64 v[], size_t n) { return n ? ERR : OK; }
F3(GetNumberOfEventIndicators, C c, size_t *n) { *n = 0; return OK; }
F3(GetOutputDerivatives, C c, Refs vr, size_t n, const fmi3Int32 o[], fmi3Float64 v[], size_t k) { return ERR; }
F3(DoStep, C c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean keep, fmi3Boolean *event, fmi3Boolean *ends,
   fmi3Boolean *early, fmi3Float64 *last)
{
    *event = *ends = *early = fmi3False;
    *last = t + h;
    return advance(c, t, h);
}
F3(ActivateModelPartition, C c, fmi3ValueReference vr, fmi3Float64 t) { return ERR; }
F3(GetNumberOfContinuousStates, C c, size_t *n) { *n = STATES; return OK; }
F3(GetContinuousStates, C c, fmi3Float64 x[], size_t n) { return states(c, Q_STATE, x, n, 0); }
F3(SetContinuousStates, C c, const fmi3Float64 x[], size_t n) { return states(c, Q_STATE, (double *)x, n, 1); }
F3(GetContinuousStateDerivatives, C c, fmi3Float64 x[], size_t n) { return states(c, RATES, x, n, 0); }
F3(GetNominalsOfContinuousStates, C c, fmi3Float64 x[], size_t n) { return ones(x, n); }
