// Whether work groups of one item do what the lane shape needs: vectors of 16 stored to local memory and loaded back
// shifted, private counters, several groups at once. (One driver was seen to get this wrong.)
//
//   out    result [groups * CHECK_LENGTH]: see lane_shape_check.cpp, which computes the same
//   launch any number of groups of one item
#include "work_group.clh"
#include "lane_check_constants.h"

KERNEL void lane_shape_check(global uint* result) {
    local uint rows[CHECK_ROWS * CHECK_STRIDE] __attribute__((aligned(64)));
    const uint16 lanes = (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const uint group = (uint)get_group_id(0);
    for (uint t = 0; t < CHECK_STRIDE; t += 16) {
        for (uint r = 0; r < CHECK_ROWS; ++r) {
            vstore16((group * 7919u + (t + lanes) * 31u + r * 101u) * 2654435761u, 0, rows + r * CHECK_STRIDE + t);
        }
    }
    uint counters[16];
    for (uint k = 0; k < 16; ++k) {
        counters[k] = 0;
    }
    for (uint t = 0; t < CHECK_LENGTH; t += 16) {
        uint16 best = 0xffffffffu;
        for (uint r = 0; r < CHECK_ROWS; ++r) {
            const uint16 value = vload16(0, rows + r * CHECK_STRIDE + t + CHECK_ROWS - r);
            best = value < best ? value : best;
        }
        vstore16(best, 0, rows + t);
    }
    for (uint t = 0; t < CHECK_LENGTH; ++t) {
        result[group * CHECK_LENGTH + t] = rows[t] + counters[rows[t] & 15]++;
    }
}
