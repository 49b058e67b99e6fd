/* Strake plug-ins: values, and optionally gradients, of a surface from a shared library. Plain C, version 1.
 *
 *     cc -O2 -shared -fPIC -I PREFIX/include -o area.so area.c
 *
 *     quantities:
 *       area: {plugin: {library: area.so, options: "any text"}}
 *
 * The library runs inside Strake: if it crashes or never returns, so does Strake. A separate program (`command`) is
 * safer; use a plug-in for what takes milliseconds. docs/external.md has an example.
 */
#ifndef STRAKE_PLUGIN_H
#define STRAKE_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STRAKE_PLUGIN_ABI 1

/* The request. Valid only during the call. Later versions may append fields: `size` is the number of bytes. */
typedef struct strake_plugin_request {
    size_t size;
    int32_t evaluation; /* number within the run, from 1 */
    int32_t level;
    size_t num_vertices;
    const double* vertices; /* num_vertices x 3: x, y, z vertex by vertex */
    size_t num_triangles;
    const int32_t* triangles; /* num_triangles x 3 vertices, from 0, counterclockwise seen from outside */
    size_t num_variables;     /* parameters of the case (`variables:`); angles in radians */
    const char* const* variable_names;
    const double* variables;
    size_t num_values; /* as `outputs` in the case; "value" if it has none */
    const char* const* value_names;
    int32_t want_gradients;
} strake_plugin_request;

/* The answer. All numbers are NaN before the call; a value that stays NaN is a failure. */
typedef struct strake_plugin_result {
    size_t size;
    double* values;      /* num_values */
    double* gradients;   /* num_values x num_vertices x 3: d value / d position of a vertex; NULL if not wanted */
    double* by_variable; /* num_values x num_variables, at fixed shape; NULL if not wanted */
    char* error;         /* UTF-8, 0-terminated: why there is no answer */
    size_t error_size;   /* bytes of `error`, including the 0 */
} strake_plugin_result;

/* ---- what the library exports ---- */

/* Must return STRAKE_PLUGIN_ABI. */
uint32_t strake_plugin_abi(void);

/* Optional. Called once, with the text of `options` (never NULL). *state is passed to the other functions.
 * Returns 0, or another value with a message in `error`. */
int strake_plugin_open(const char* options, void** state, char* error, size_t error_size);

/* Returns 0, or another value with a message in result->error. The same request must give the same numbers. Never
 * called by two threads at once with the same state. */
int strake_plugin_evaluate(void* state, const strake_plugin_request* request, strake_plugin_result* result);

/* Optional. Called once, at the end. */
void strake_plugin_close(void* state);

#ifdef __cplusplus
}
#endif

#endif /* STRAKE_PLUGIN_H */
