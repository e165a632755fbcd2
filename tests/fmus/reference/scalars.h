/* Values by reference in FMI 1.0 and 2.0, where each reference has one. Who includes this has an Instance, a function
   say, FMI, which makes the name of a type or a status, and F, that of a function. */

#define ACCESS(NAME, TYPE, KIND)                                                                                      \
    FMI(Status) F(Get##NAME)(FMI(Component) c, const FMI(ValueReference) r[], size_t n, TYPE v[]) {                   \
        for (size_t k = 0; k < n; k++) {                                                                              \
            const TYPE *from = model_value(&((Instance *)c)->state, r[k], KIND);                                      \
            if (!from) return say(c, FMI(Error), "no such variable");                                                 \
            v[k] = *from;                                                                                             \
        }                                                                                                             \
        return FMI(OK);                                                                                               \
    }                                                                                                                 \
    FMI(Status) F(Set##NAME)(FMI(Component) c, const FMI(ValueReference) r[], size_t n, const TYPE v[]) {             \
        for (size_t k = 0; k < n; k++) {                                                                              \
            TYPE *to = model_value(&((Instance *)c)->state, r[k], KIND);                                              \
            if (!to) return say(c, FMI(Error), "no such variable");                                                   \
            *to = v[k];                                                                                               \
        }                                                                                                             \
        return FMI(OK);                                                                                               \
    }

ACCESS(Real, FMI(Real), FLOAT64)
ACCESS(Integer, FMI(Integer), INT32)
ACCESS(Boolean, FMI(Boolean), BOOLEAN)

FMI(Status) F(GetString)(FMI(Component) c, const FMI(ValueReference) r[], size_t n, FMI(String) v[]) {
    for (size_t k = 0; k < n; k++) {
        const char *from = model_value(&((Instance *)c)->state, r[k], STRING);
        if (!from) return say(c, FMI(Error), "no such variable");
        v[k] = from;
    }
    return FMI(OK);
}

FMI(Status) F(SetString)(FMI(Component) c, const FMI(ValueReference) r[], size_t n, const FMI(String) v[]) {
    for (size_t k = 0; k < n; k++) {
        char *to = model_value(&((Instance *)c)->state, r[k], STRING);
        if (!to) return say(c, FMI(Error), "no such variable");
        if (strlen(v[k]) >= TEXT) return say(c, FMI(Error), "the text is too long");
        strcpy(to, v[k]);
    }
    return FMI(OK);
}
