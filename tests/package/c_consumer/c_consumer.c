/* A C program that builds a tree on the host, and has an error told. */

#include <clbvh/clbvh.h>
#include <clbvh/version.h>
#include <string.h>

int main(void) {
    const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t triangle[3] = {0, 1, 2};
    const uint32_t out_of_range[3] = {0, 1, 3};
    clbvh_builder* builder = 0;
    uint64_t count = 0;
    int failed = 1;
    if (clbvh_version() != CLBVH_VERSION_NUMBER || strcmp(clbvh_version_string(), CLBVH_VERSION_STRING) != 0) return 2;
    if (clbvh_create_builder("sweep-sah", 0, &builder) == CLBVH_OK &&
        clbvh_build(builder, vertices, 3, triangle, 1) == CLBVH_OK) {
        const clbvh_node* nodes = clbvh_nodes(builder, &count);
        failed = count != 2 || nodes[0].count != 1;
        if (clbvh_build(builder, vertices, 3, out_of_range, 1) != CLBVH_INVALID_INPUT) failed = 3;
    }
    clbvh_destroy_builder(builder);
    return failed;
}
