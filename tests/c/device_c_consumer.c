/* Uses clbvh.h as a C program would. Returns 0 where one triangle became one leaf. */

#include "clbvh/clbvh.h"

int clbvh_c_consumer(void);

int clbvh_c_consumer(void) {
    const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t triangle[3] = {0, 1, 2};
    clbvh_builder* builder = 0;
    uint64_t count = 0;
    int failed = 1;
    if (clbvh_create_builder("plocpp", 0, &builder) == CLBVH_OK &&
        clbvh_set_option(builder, "ploc.search_radius", "8") == CLBVH_OK &&
        clbvh_build(builder, vertices, 3, triangle, 1) == CLBVH_OK) {
        const clbvh_node* nodes = clbvh_nodes(builder, &count);
        failed = count != 2 || nodes[0].count != 1 || nodes[0].upper[0] != 1.0f;
    }
    clbvh_destroy_builder(builder);
    return failed;
}
