/* The C interface: a builder, a tree over a strip of triangles, and its nodes. */

#include <clbvh/clbvh.h>
#include <stdint.h>
#include <stdio.h>

#define TRIANGLE_COUNT 1000

int main(void) {
    static float vertices[3 * (TRIANGLE_COUNT + 2)];
    static uint32_t triangles[3 * TRIANGLE_COUNT];
    for (uint32_t i = 0; i < TRIANGLE_COUNT + 2; ++i) {
        vertices[3 * i] = (float)i;
        vertices[3 * i + 1] = (float)(i % 2);
    }
    for (uint32_t i = 0; i < 3 * TRIANGLE_COUNT; ++i) {
        triangles[i] = i / 3 + i % 3;
    }

    clbvh_builder* builder = NULL;
    if (clbvh_create_builder("plocpp", NULL, &builder) != CLBVH_OK ||
        clbvh_set_option(builder, "ploc.search_radius", "8") != CLBVH_OK ||
        clbvh_build(builder, vertices, TRIANGLE_COUNT + 2, triangles, TRIANGLE_COUNT) != CLBVH_OK) {
        fprintf(stderr, "hello_c: %s\n", clbvh_last_error());
        clbvh_destroy_builder(builder);
        return 1;
    }
    uint64_t node_count = 0;
    const clbvh_node* nodes = clbvh_nodes(builder, &node_count);
    const float right = nodes[0].upper[0];
    printf("%u triangles, %llu nodes, from x = %g to %g\n", (unsigned)TRIANGLE_COUNT, (unsigned long long)node_count,
           nodes[0].lower[0], right);
    clbvh_destroy_builder(builder);
    return node_count == 2 * TRIANGLE_COUNT && right == (float)(TRIANGLE_COUNT + 1) ? 0 : 1;
}
