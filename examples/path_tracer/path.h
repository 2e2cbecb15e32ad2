// What a path does, but for tracing: read by OpenCL C and by C++, which has a float3 of its own (path_tracer.cpp).
// Sums, products, quotients and square roots are all that it takes, so that both get the same bits.
#define BOUNCES 4
#define RAY_BEGIN 1e-3f

// A permuted congruential generator (O'Neill 2014).
static inline float random_unit(uint* state) {
    *state = *state * 747796405u + 2891336453u;
    const uint word = ((*state >> ((*state >> 28) + 4)) ^ *state) * 277803737u;
    return (float)(((word >> 22) ^ word) >> 8) * (1.0f / 16777216.0f);
}

static inline float dot3(float3 a, float3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float3 unit(float3 v) {
    return v * (1.0f / sqrt(dot3(v, v)));
}

static inline float3 eye(void) {
    return make3(50.0f, -45.0f, 50.0f);
}

static inline float3 through_pixel(uint pixel, uint width, uint height, uint* state) {
    const float x = (float)(pixel % width) + random_unit(state), y = (float)(pixel / width) + random_unit(state);
    const float size = 1.0f / (float)height;
    return unit(make3(x * size - 0.5f * (float)width * size, 0.9f, 0.1f - y * size));
}

// The triangle's normal on the side from which the ray comes.
static inline float3 normal_against(float3 direction, float3 a, float3 b, float3 c) {
    const float3 d = b - a, e = c - a;
    const float3 normal = unit(make3(d.y * e.z - d.z * e.y, d.z * e.x - d.x * e.z, d.x * e.y - d.y * e.x));
    return dot3(normal, direction) > 0.0f ? normal * -1.0f : normal;
}

// Diffuse: a point on the unit sphere around the normal's end.
static inline float3 scatter(float3 normal, uint* state) {
    for (;;) {
        const float x = 2.0f * random_unit(state) - 1.0f, y = 2.0f * random_unit(state) - 1.0f;
        const float3 p = make3(x, y, 2.0f * random_unit(state) - 1.0f);
        if (dot3(p, p) <= 1.0f && dot3(p, p) > 1e-4f) return normal + unit(p);
    }
}

static inline float3 sky(float3 direction) {
    const float height = 0.5f + 0.5f * unit(direction).z;
    return make3(0.9f - 0.5f * height, 0.9f - 0.3f * height, 1.0f);
}

static inline float3 to_sun(void) {
    return make3(0.6f, -0.3f, 0.5f);
}

static inline float3 sunlight(float3 normal) {
    const float cosine = dot3(normal, unit(to_sun()));
    return make3(1.6f, 1.4f, 1.1f) * (cosine > 0.0f ? cosine : 0.0f);
}

static inline float3 colour_of(uint primitive) {
    return (primitive / 40) % 2 == 0 ? make3(0.7f, 0.5f, 0.3f) : make3(0.4f, 0.6f, 0.4f);
}
