/* Plug-ins of Strake: values, and maybe gradients, of a surface from a shared library. Plain C, version 1.
 *
 *     cc -O2 -shared -fPIC -I PREFIX/include -o area.so area.c
 *
 *     quantities:
 *       area: {plugin: {library: area.so, options: "any text"}}
 *
 * The library runs inside of Strake: what crashes it or never ends takes Strake with it. A program of its own
 * (`command`) is safer; a plug-in is for what takes milliseconds. docs/external.md has an example.
 */
#ifndef STRAKE_PLUGIN_H
#define STRAKE_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STRAKE_PLUGIN_ABI 1

/* What is to be evaluated. Valid during the call only. Later versions may append fields: `size` tells how many bytes
 * there are. */
typedef struct strake_plugin_request {
    size_t size;
    int32_t evaluation; /* number within the run, from 1 */
    int32_t level;
    size_t num_vertices;
    const double* vertices; /* num_vertices x 3: x, y, z of one vertex after the other */
    size_t num_triangles;
    const int32_t* triangles; /* num_triangles x 3 vertices, from 0, counterclockwise seen from outside */
    size_t num_variables;     /* the case's own variables; angles in radians */
    const char* const* variable_names;
    const double* variables;
    size_t num_values; /* as `gives` in the case; "value" where it has none */
    const char* const* value_names;
    int32_t want_gradients;
} strake_plugin_request;

/* Where the answer goes. All numbers are NaN before the call: what stays NaN is a failure. */
typedef struct strake_plugin_result {
    size_t size;
    double* values;      /* num_values */
    double* gradients;   /* num_values x num_vertices x 3: d value / d position of a vertex; NULL when not wanted */
    double* by_variable; /* num_values x num_variables, at fixed shape; NULL when not wanted */
    char* error;         /* UTF-8, ended by 0: why there is no answer */
    size_t error_size;   /* bytes of `error`, with the 0 */
} strake_plugin_result;

/* ---- what the library exports ---- */

/* Must return STRAKE_PLUGIN_ABI. */
uint32_t strake_plugin_abi(void);

/* May be missing. Called once, with the text of `options` (never NULL). *state is handed to the other functions.
 * Returns 0, or anything else with a text in `error`. */
int strake_plugin_open(const char* options, void** state, char* error, size_t error_size);

/* Returns 0, or anything else with a text in result->error. The same request must give the same numbers. Never called
 * by two threads at a time with the same state. */
int strake_plugin_evaluate(void* state, const strake_plugin_request* request, strake_plugin_result* result);

/* May be missing. Called once, at the end. */
void strake_plugin_close(void* state);

#ifdef __cplusplus
}
#endif

#endif /* STRAKE_PLUGIN_H */
