#include "components.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "library.h"
#include "messages.h"
#include "operations.h"

typedef struct {
    const char *name;
    size_t place; /* in functions_t */
} symbol_t;

#define PLACE(member) offsetof(functions_t, member)

static const symbol_t symbols[] = {
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
    for (size_t k = 0; k < sizeof symbols / sizeof *symbols; k++) {
        void *found = library_symbol(component->call.library, symbols[k].name);
        if (found == NULL)
            return refuse(bundle, "%s: its library has no function %s", component->name, symbols[k].name);
        memcpy((char *)&component->call + symbols[k].place, &found, sizeof found);
    }
    return fmi2OK;
}

static fmi2Status instantiate(component_t *component)
{
    bundle_t *bundle = component->bundle;
    size_t room = strlen(bundle->resources_uri) + strlen(component->folder) + sizeof "//resources";
    char *uri = malloc(room);

    if (uri == NULL)
        return refuse(bundle, "%s: there is no memory", component->name);
    snprintf(uri, room, "%s/%s/resources", bundle->resources_uri, component->folder);
    component->callbacks.allocateMemory = bundle->host.allocate;
    component->callbacks.freeMemory = bundle->host.release;
    component->callbacks.logger = component_message;
    component->callbacks.stepFinished = NULL;
    component->callbacks.componentEnvironment = component;
    component->worst = fmi2OK;
    component->instance = component->call.instantiate(component->name, fmi2CoSimulation, component->guid, uri,
                                                      &component->callbacks, fmi2False, bundle->logging);
    free(uri);
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
    return judge(component, "fmi2SetDebugLogging",
                 component->call.set_debug_logging(component->instance, on ? fmi2True : fmi2False, 0, NULL));
}

void unload_components(bundle_t *bundle)
{
    for (uint32_t k = bundle->component_count; k-- > 0;) {
        component_t *component = &bundle->components[k];
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
