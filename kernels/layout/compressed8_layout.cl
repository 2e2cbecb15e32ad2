// A layout of up to eight children a node whose boxes take a byte a plane (clbvh/layout/compressed8.hpp), the same
// bytes as the host's make_layout(), from a binary tree: pieces.clh says how. Every array is a buffer, and an offset in
// bytes of ScenePlace or LayoutPlace (layout_constants.h), whose blocks are the triangles.
//
//   out    header [LAYOUT_HEADER_WORDS]; nodes, triangles (layout_constants.h)
#define FOR_COMPRESSED8 1
#include "work_group.clh"
#include "place.clh"
#include "aabb.clh"
#include "input.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "open_piece.clh"
#include "write_compressed8.clh"
#include "pieces.clh"
