// Whether one work group finds what another hands over within a launch: "message passing", the litmus test, as the
// kernels do it that climb trees (between_groups.clh), and at every distance between groups. Whoever comes second to a
// meeting place counts the words that are not what whoever came first has sent.
//
// On the way a word crosses barriers: half of what an item announces its neighbour in the group has published, and half
// of what it is told of its neighbour looks for.
//
//   in     launch: another number than in any launch before, not 0
//   inout  meetings [places]: zeros before the first launch; words [places * HAND_OVER_WORDS]; places =
//          HAND_OVER_DISTANCES * HAND_OVER_GROUPS / 2 * WORK_GROUP_SIZE
//          found [3]: words that were looked for, and of these the wrong ones; what else was read
//   launch HAND_OVER_GROUPS groups
//   local  WORK_GROUP_SIZE bytes
#include "work_group.clh"
#include "between_groups.clh"
#include "hand_over_constants.h"

// Words of a side that are published, so that a test can hold some back.
#ifndef HAND_OVER_PUBLISHED
#define HAND_OVER_PUBLISHED HAND_OVER_SENT
#endif
#define HAND_OVER_SIDE (HAND_OVER_WORDS / 2)

// The item beside this one in its group.
#define NEIGHBOUR_OF(item) (WORK_GROUP_SIZE > 1 ? (item) ^ 1u : (item))

static inline uint word_of(uint launch, size_t place, uint side, uint k) {
    return (launch * 2654435761u) ^ ((uint)place * 2246822519u) ^ (side * 3266489917u) ^ (k * 668265263u);
}

// Where the item meets the one of the same number in the group that is 1 << distance away.
static inline size_t place_of(uint distance, uint item) {
    const uint group = (uint)get_group_id(0);
    const uint below = group & ((1u << distance) - 1);
    const uint pair = (group >> (distance + 1)) << distance | below;
    return ((size_t)distance * (HAND_OVER_GROUPS / 2) + pair) * WORK_GROUP_SIZE + item;
}

static inline void publish_half(global uint* words, uint launch, size_t place, uint side, uint half_of_them) {
    for (uint k = half_of_them; k < HAND_OVER_PUBLISHED; k += 2)
        publish_word(words + HAND_OVER_WORDS * place + HAND_OVER_SIDE * side + k, word_of(launch, place, side, k));
}

static inline uint wrong_words(global uint* words, uint launch, size_t place, uint side, uint half_of_them) {
    uint wrong = 0;
    for (uint k = half_of_them; k < HAND_OVER_SENT; k += 2)
        wrong += observe_word(words + HAND_OVER_WORDS * place + HAND_OVER_SIDE * side + k) !=
                 word_of(launch, place, side, k);
    return wrong;
}

KERNEL void hand_over_check(global uint* meetings, global uint* words, uint launch, global uint* found) {
    local uchar is_second[WORK_GROUP_SIZE];
    const uint item = LOCAL_ID, neighbour = NEIGHBOUR_OF(item);
    uint looked_for = 0, wrong = 0, beside = 0;
    for (uint distance = 0; distance < HAND_OVER_DISTANCES; ++distance) {
        const uint side = (uint)get_group_id(0) >> distance & 1u;
        const size_t place = place_of(distance, item), other_place = place_of(distance, neighbour);
        // A cache may now hold the line with what the words were. (Nobody writes the one that is read.)
        beside += words[HAND_OVER_WORDS * place + HAND_OVER_SIDE * (1 - side) + HAND_OVER_SENT];
        publish_half(words, launch, place, side, 0);
        publish_half(words, launch, other_place, side, 1);
        DEVICE_FENCE();
        GLOBAL_BARRIER();
        DEVICE_FENCE();
        is_second[item] = atomic_xchg(meetings + place, launch) == launch;
        DEVICE_FENCE();
        GLOBAL_BARRIER();
        if (is_second[item]) {
            wrong += wrong_words(words, launch, place, 1 - side, 0);
            looked_for += HAND_OVER_SENT / 2;
        }
        if (is_second[neighbour]) {
            wrong += wrong_words(words, launch, other_place, 1 - side, 1);
            looked_for += HAND_OVER_SENT / 2;
        }
        LOCAL_BARRIER();
    }
    atomic_add(found, looked_for);
    atomic_add(found + 1, wrong);
    atomic_add(found + 2, beside);
}
