/* The end of initialisation and of stepping, in FMI 2.0 and 3.0. Who includes this has an Instance that knows whether
   it is stepping, a function say, and FMI, which makes a name of its version. */

FMI(Status) FMI(ExitInitializationMode)(void *c) {
    model_initialise(&((Instance *)c)->state);
    ((Instance *)c)->stepping = true;
    return FMI(OK);
}

FMI(Status) FMI(Terminate)(void *c) {
    if (!((Instance *)c)->stepping) return say(c, FMI(Error), "terminated without a step");
    ((Instance *)c)->stepping = false;
    return say(c, FMI(Warning), "terminated");
}
