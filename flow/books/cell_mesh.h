#pragma once

#include "samara/codebooks/book/space_mesh.h"
#include "samara/flow/grid/openness.h"
#include "samara/flow/march/flow_case.h"
#include "samara/pgd/axes/axis.h"

/// The cells of a grid as the nodes of a codebook: numbered from the lower corner, x running fastest, then y, then z.
namespace samara::flow {

/// Their centres in body lengths, with triangles or tetrahedra between them.
codebooks::SpaceMesh cell_mesh(const MacGrid& grid);

/// Their numbers as an axis named "node": every cell counts by its volume.
pgd::Axis cell_axis(const MacGrid& grid);

/// A field of cells by their numbers, and back, with margins of 0.
Eigen::VectorXd cells_in_order(const MacGrid& grid, const Field& field);
Field field_in_order(const MacGrid& grid, const Eigen::VectorXd& values);

/// Gives closed cells the mean of their neighbours, layer by layer from the surface inward.
void continue_into_body(const MacGrid& grid, const Openness& body, Field& field);

/// The open share of cells about the body of a case.
Field open_cells(const FlowCase& flow, const MacGrid& grid);

}  // namespace samara::flow
