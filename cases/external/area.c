/* The area of a surface and its gradient, as a plug-in of Strake. Copy this and put your own number in.
 *
 *     cc -O2 -shared -fPIC -I include -o area.so cases/external/area.c
 */
#include <math.h>
#include <string.h>

#include "strake/plugin.h"

uint32_t strake_plugin_abi(void) { return STRAKE_PLUGIN_ABI; }

static void cross(const double* a, const double* b, double* c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

int strake_plugin_evaluate(void* state, const strake_plugin_request* request, strake_plugin_result* result) {
    double area = 0;
    (void)state;
    if (request->want_gradients) memset(result->gradients, 0, 3 * request->num_vertices * sizeof(double));
    for (size_t t = 0; t < request->num_triangles; ++t) {
        const int32_t* v = request->triangles + 3 * t;
        double p[3][3], normal[3], length, ab[3], ac[3];
        for (int k = 0; k < 3; ++k)
            for (int c = 0; c < 3; ++c) p[k][c] = request->vertices[3 * (size_t)v[k] + (size_t)c];
        for (int c = 0; c < 3; ++c) ab[c] = p[1][c] - p[0][c], ac[c] = p[2][c] - p[0][c];
        cross(ab, ac, normal); /* twice the area long */
        length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        if (!(length > 0)) {
            strncpy(result->error, "a triangle has no area", result->error_size - 1);
            return 1;
        }
        area += length / 2;
        for (int k = 0; request->want_gradients && k < 3; ++k) {
            /* d area / d p_k = normal x (opposite edge) / (2 |normal|) */
            double edge[3], change[3];
            for (int c = 0; c < 3; ++c) edge[c] = p[(k + 2) % 3][c] - p[(k + 1) % 3][c];
            cross(normal, edge, change);
            for (int c = 0; c < 3; ++c) result->gradients[3 * (size_t)v[k] + (size_t)c] += change[c] / (2 * length);
        }
    }
    result->values[0] = area;
    return 0;
}
