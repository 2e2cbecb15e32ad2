// Behind clbvh_trace.clh, make3() and path.h. One work item a pixel.
static float3 vertex_of(__global const float* vertices, uint i) {
    return vload3(i, vertices);
}

__kernel void render(__global const float8* nodes, __global const float4* blocks, uint block_count,
                     __global const float* vertices, __global const uint* corners, uint width, uint height,
                     uint samples, __global float* picture) {
    const clbvh_wide8 scene = {nodes, blocks, block_count};
    const uint pixel = get_global_id(0);
    float3 sum = 0.0f;
    for (uint sample = 0; sample < samples; ++sample) {
        uint state = pixel * samples + sample;
        float3 origin = eye(), direction = through_pixel(pixel, width, height, &state), weight = 1.0f;
        for (uint bounce = 0; bounce < BOUNCES; ++bounce) {
            const clbvh_hit hit = clbvh_closest(scene, clbvh_make_ray(origin, direction, RAY_BEGIN, INFINITY), 0);
            if (hit.primitive == CLBVH_NO_PRIMITIVE) {
                sum = sum + weight * sky(direction);
                break;
            }
            __global const uint* const corner = corners + 3 * hit.primitive;
            const float3 normal = normal_against(direction, vertex_of(vertices, corner[0]),
                                                 vertex_of(vertices, corner[1]), vertex_of(vertices, corner[2]));
            origin = origin + direction * hit.t;
            weight = weight * colour_of(hit.primitive);
            if (!clbvh_any(scene, clbvh_make_ray(origin, to_sun(), RAY_BEGIN, INFINITY), 0))
                sum = sum + weight * sunlight(normal);
            direction = scatter(normal, &state);
        }
    }
    vstore3(sum * (1.0f / (float)samples), pixel, picture);
}
