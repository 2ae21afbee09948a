// Third step of the field, second part: the base vector of each sample, equation (4) of the paper.
//
// f = Gr - Gc. C is a smooth ball of 3.5 voxels about the sample that ends where another face of
// the body begins: a voxel belongs to C if all surfaces in it face as the sample's own face does
// there, to 18 deg, and so do those at its mirror place beyond the sample's normal. A ball that
// reaches across an edge is blunt there: a nut then sticks on its bolt, and a box leans. Without
// the mirror C is lopsided beside an edge, and a nut locks at a friction of 0.031 instead of 0.036.
//
// The own face is as the fit has it: across the fitted normal n, and as curved as its 3x3x3 block.
// Gr lies where the vector of such a face is exactly its normal. With w the ball's weight, m the
// part of a voxel below the own face, c the measured coverage and r the way from the sample to the
// voxel's center,
//
//   f = L n + (sum over C of w (m - c) r) / (sum over the ball of w m),
//
// where L = 35/128 of the ball's radius is the length of a flat face's vector. So what lies outside
// C counts as the own face, continued; and Gc decides: the measured matter of 180 voxels, where the
// fit sees 27. On a cylinder of 10 voxels' radius f is right to 0.10 deg, the fit to 0.19. A flat
// own face (0.39 deg there) is not enough. Right at an edge C holds next to nothing, and f is the
// fitted normal.
//
// Area times depth times such a vector, summed over the samples in the other body, is the mean of
// the base vectors of all elements of the overlap (docs/method.md, "The theorem").
#pragma once

#include "field/field_draft.h"
#include "field/sample_set.h"

namespace cloudcontact {

// [voxels] A sample's vector reads coverage and pieces up to this far from its voxel.
constexpr int kVectorReach = 6;

// Puts the direction of each sample's base vector in place of its fitted normal.
void giveBaseVectors(const FieldDraft& draft, std::vector<CutSample>& samples);

}  // namespace cloudcontact
