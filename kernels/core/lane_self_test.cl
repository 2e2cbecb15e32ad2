// Whether work groups of one item do what the lane shape needs: vectors of 16 stored to local memory and loaded back
// shifted, private counters, several groups at once. (One driver was seen to get this wrong.)
//
//   out    result [groups * SELF_TEST_LENGTH]: see lane_self_test.cpp, which computes the same
//   launch any number of groups of one item
#include "work_group.clh"

#define SELF_TEST_LENGTH 64
#define SELF_TEST_ROWS 16
#define SELF_TEST_STRIDE (SELF_TEST_LENGTH + 32)

KERNEL void lane_self_test(global uint* result) {
    local uint rows[SELF_TEST_ROWS * SELF_TEST_STRIDE] __attribute__((aligned(64)));
    const uint16 lanes = (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const uint group = (uint)get_group_id(0);
    for (uint t = 0; t < SELF_TEST_STRIDE; t += 16) {
        for (uint r = 0; r < SELF_TEST_ROWS; ++r) {
            vstore16((group * 7919u + (t + lanes) * 31u + r * 101u) * 2654435761u, 0, rows + r * SELF_TEST_STRIDE + t);
        }
    }
    uint counters[16];
    for (uint k = 0; k < 16; ++k) {
        counters[k] = 0;
    }
    for (uint t = 0; t < SELF_TEST_LENGTH; t += 16) {
        uint16 best = 0xffffffffu;
        for (uint r = 0; r < SELF_TEST_ROWS; ++r) {
            const uint16 value = vload16(0, rows + r * SELF_TEST_STRIDE + t + SELF_TEST_ROWS - r);
            best = value < best ? value : best;
        }
        vstore16(best, 0, rows + t);
    }
    for (uint t = 0; t < SELF_TEST_LENGTH; ++t) {
        result[group * SELF_TEST_LENGTH + t] = rows[t] + counters[rows[t] & 15]++;
    }
}
