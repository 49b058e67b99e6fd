/* A plug-in that misbehaves as its options say; compiled without one of its functions or for another version, too. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "strake/plugin.h"

#ifndef BAD_ABI
#define BAD_ABI STRAKE_PLUGIN_ABI
#endif
uint32_t strake_plugin_abi(void) { return BAD_ABI; }

int strake_plugin_open(const char* options, void** state, char* error, size_t error_size) {
    if (strcmp(options, "refuse") == 0) {
        snprintf(error, error_size, "no licence for %s", options);
        return 7;
    }
    if (strcmp(options, "wander") == 0 && chdir("/") != 0) return 8;
    *state = strdup(options);
    return 0;
}

#ifndef WITHOUT_EVALUATE
int strake_plugin_evaluate(void* state, const strake_plugin_request* request, strake_plugin_result* result) {
    const char* role = state;
    if (strcmp(role, "fail") == 0) {
        snprintf(result->error, result->error_size, "diverged at %d\x1b[31m", request->evaluation);
        return 1;
    }
    if (strcmp(role, "silent") == 0) return 2;
    if (strcmp(role, "wander") == 0 && chdir("/") != 0) return 3;
    if (strcmp(role, "exit") == 0) exit(0);
    for (size_t i = 0; i < request->num_values; ++i) {
        result->values[i] = request->vertices[0] + (double)i;
        if (strcmp(role, "forget") == 0 && i == 1) result->values[i] = 0.0 / 0.0;
        for (size_t k = 0; result->gradients && k < 3 * request->num_vertices; ++k)
            result->gradients[3 * request->num_vertices * i + k] = k == 0;
        for (size_t j = 0; result->by_variable && j < request->num_variables; ++j)
            if (strcmp(request->variable_names[j], "alpha") == 0)
                result->by_variable[request->num_variables * i + j] = request->variables[j];
        if (result->gradients && strcmp(role, "no gradient") == 0) result->gradients[4] = 0.0 / 0.0;
    }
    return 0;
}
#endif

void strake_plugin_close(void* state) { free(state); }
