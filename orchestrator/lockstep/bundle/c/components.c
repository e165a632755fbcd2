#include "components.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arrays.h"
#include "library.h"
#include "messages.h"
#include "operations.h"

typedef struct {
    const char *name;
    size_t place; /* in functions_t */
} symbol_t;

#define PLACE(member) offsetof(functions_t, member)

static const symbol_t symbols2[] = {
    {"fmi2Instantiate", PLACE(instantiate)},
    {"fmi2FreeInstance", PLACE(free_instance)},
    {"fmi2SetDebugLogging", PLACE(set_debug_logging)},
    {"fmi2SetupExperiment", PLACE(setup_experiment)},
    {"fmi2EnterInitializationMode", PLACE(enter_initialization)},
    {"fmi2ExitInitializationMode", PLACE(exit_initialization)},
    {"fmi2Terminate", PLACE(terminate)},
    {"fmi2Reset", PLACE(reset)},
    {"fmi2DoStep", PLACE(do_step)},
    {"fmi2GetReal", PLACE(get[REAL])},
    {"fmi2GetInteger", PLACE(get[INTEGER])},
    {"fmi2GetBoolean", PLACE(get[BOOLEAN])},
    {"fmi2GetString", PLACE(get[STRING])},
    {"fmi2SetReal", PLACE(set[REAL])},
    {"fmi2SetInteger", PLACE(set[INTEGER])},
    {"fmi2SetBoolean", PLACE(set[BOOLEAN])},
    {"fmi2SetString", PLACE(set[STRING])},
    {"fmi2GetFMUstate", PLACE(get_state)},
    {"fmi2SetFMUstate", PLACE(set_state)},
    {"fmi2FreeFMUstate", PLACE(free_state)},
    {"fmi2SerializedFMUstateSize", PLACE(state_size)},
    {"fmi2SerializeFMUstate", PLACE(serialize)},
    {"fmi2DeSerializeFMUstate", PLACE(deserialize)},
    {"fmi2GetRealStatus", PLACE(real_status)},
    {"fmi2GetBooleanStatus", PLACE(boolean_status)},
    {NULL, 0},
};

static const symbol_t symbols3[] = {
    {"fmi3InstantiateCoSimulation", PLACE(instantiate3)},
    {"fmi3FreeInstance", PLACE(free_instance)},
    {"fmi3SetDebugLogging", PLACE(set_debug_logging3)},
    {"fmi3EnterInitializationMode", PLACE(enter_initialization3)},
    {"fmi3ExitInitializationMode", PLACE(exit_initialization)},
    {"fmi3Terminate", PLACE(terminate)},
    {"fmi3Reset", PLACE(reset)},
    {"fmi3DoStep", PLACE(do_step3)},
    {"fmi3GetFloat64", PLACE(get3[REAL])},
    {"fmi3GetInt32", PLACE(get3[INTEGER])},
    {"fmi3GetBoolean", PLACE(get3[BOOLEAN])},
    {"fmi3GetString", PLACE(get3[STRING])},
    {"fmi3SetFloat64", PLACE(set3[REAL])},
    {"fmi3SetInt32", PLACE(set3[INTEGER])},
    {"fmi3SetBoolean", PLACE(set3[BOOLEAN])},
    {"fmi3SetString", PLACE(set3[STRING])},
    {"fmi3GetFMUState", PLACE(get_state)},
    {"fmi3SetFMUState", PLACE(set_state)},
    {"fmi3FreeFMUState", PLACE(free_state)},
    {"fmi3SerializedFMUStateSize", PLACE(state_size)},
    {"fmi3SerializeFMUState", PLACE(serialize)},
    {"fmi3DeserializeFMUState", PLACE(deserialize)},
    {NULL, 0},
};

fmi2Status worse(fmi2Status one, fmi2Status other)
{
    return other > one ? other : one;
}

static int exists(const char *path)
{
    FILE *file = open_to_read(path);

    if (file != NULL)
        fclose(file);
    return file != NULL;
}

static fmi2Status load(component_t *component)
{
    bundle_t *bundle = component->bundle;
    size_t room = strlen(bundle->resources) + strlen(component->folder) + strlen(component->identifier) + 64;
    char *path = malloc(room), reason[500];

    if (path == NULL)
        return refuse(bundle, "%s: there is no memory", component->name);
    for (int k = 0; k < LIBRARY_PLACES; k++) {
        snprintf(path, room, "%s/%s/binaries/%s/%s%s", bundle->resources, component->folder, library_folders[k],
                 component->identifier, library_suffix);
        if (exists(path))
            break;
    }
    component->call.library = library_open(path);
    free(path);
    if (component->call.library == NULL) {
        library_error(reason, sizeof reason);
        return refuse(bundle, "%s: its library cannot be loaded: %s", component->name, reason);
    }
    for (const symbol_t *one = component->flags & VERSION_3 ? symbols3 : symbols2; one->name != NULL; one++) {
        void *found = library_symbol(component->call.library, one->name);
        if (found == NULL)
            return refuse(bundle, "%s: its library has no function %s", component->name, one->name);
        memcpy((char *)&component->call + one->place, &found, sizeof found);
    }
    return fmi2OK;
}

static fmi2Status instantiate(component_t *component)
{
    bundle_t *bundle = component->bundle;
    const int third = (component->flags & VERSION_3) != 0;
    const char *resources = third ? bundle->resources : bundle->resources_uri;
    size_t room = strlen(resources) + strlen(component->folder) + sizeof "//resources/";
    char *place = malloc(room);

    if (place == NULL || (third && !start_arrays(component))) {
        free(place);
        return refuse(bundle, "%s: there is no memory", component->name);
    }
    snprintf(place, room, "%s/%s/resources%s", resources, component->folder, third ? "/" : "");
    component->callbacks.allocateMemory = bundle->host.allocate;
    component->callbacks.freeMemory = bundle->host.release;
    component->callbacks.logger = component_message;
    component->callbacks.stepFinished = NULL;
    component->callbacks.componentEnvironment = component;
    component->worst = fmi2OK;
    if (third)
        component->instance = component->call.instantiate3(component->name, component->guid, place, false,
                                                           bundle->logging != 0, false, false, NULL, 0, component,
                                                           component_message3, NULL);
    else
        component->instance = component->call.instantiate(component->name, fmi2CoSimulation, component->guid, place,
                                                          &component->callbacks, fmi2False, bundle->logging);
    free(place);
    if (component->instance == NULL)
        return refuse(bundle, "%s: cannot be instantiated", component->name);
    return fmi2OK;
}

fmi2Status load_components(bundle_t *bundle)
{
    fmi2Status status = fmi2OK;

    for (uint32_t k = 0; status == fmi2OK && k < bundle->component_count; k++) {
        status = load(&bundle->components[k]);
        if (status == fmi2OK)
            status = instantiate(&bundle->components[k]);
    }
    if (status == fmi2OK)
        bind_operations(bundle);
    return status;
}

fmi2Status log_component(component_t *component, int on)
{
    static const char call[] = "SetDebugLogging";

    if (component->flags & VERSION_3)
        return judge(component, call,
                     (fmi2Status)component->call.set_debug_logging3(component->instance, on != 0, 0, NULL));
    return judge(component, call,
                 component->call.set_debug_logging(component->instance, on ? fmi2True : fmi2False, 0, NULL));
}

void unload_components(bundle_t *bundle)
{
    for (uint32_t k = bundle->component_count; k-- > 0;) {
        component_t *component = &bundle->components[k];
        free_arrays(component);
        if (component->worst >= fmi2Fatal)
            continue; /* no call is allowed any more, and unloading is not safe */
        if (component->instance != NULL)
            component->call.free_instance(component->instance);
        component->instance = NULL;
        if (component->call.library != NULL)
            library_close(component->call.library);
        component->call.library = NULL;
    }
}
