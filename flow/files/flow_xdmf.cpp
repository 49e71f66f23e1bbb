#include "samara/flow/files/flow_xdmf.h"

#include <fmt/format.h>

#include "samara/base/text.h"

namespace samara::flow {

namespace {

/// "z y x" of three numbers, as XDMF lists what its arrays run over slowest first; of a plane without z.
template <class Number>
std::string slowest_first(int dimensions, Number x, Number y, Number z) {
  return dimensions == 3 ? fmt::format("{} {} {}", z, y, x) : fmt::format("{} {}", y, x);
}

}  // namespace

std::string format_xdmf(const StoredFlow& flow, const std::string& file) {
  const MacGrid& grid = flow.grid;
  const int d = grid.dimensions;
  const std::string nodes = slowest_first(d, grid.cells[0] + 1, grid.cells[1] + 1, grid.cells[2] + 1);
  const std::string cells = slowest_first(d, grid.cells[0], grid.cells[1], grid.cells[2]);
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n<Grid Name=\"flow\" GridType=\"Uniform\">\n"
      "<Topology TopologyType=\"{}DCoRectMesh\" Dimensions=\"{}\"/>\n"
      "<Geometry GeometryType=\"{}\">\n<DataItem Format=\"XML\" Dimensions=\"{}\">{}</DataItem>\n"
      "<DataItem Format=\"XML\" Dimensions=\"{}\">{}</DataItem>\n</Geometry>\n",
      d, nodes, d == 3 ? "ORIGIN_DXDYDZ" : "ORIGIN_DXDY", d,
      slowest_first(d, grid.origin.x(), grid.origin.y(), grid.origin.z()), d,
      slowest_first(d, grid.spacing, grid.spacing, grid.spacing));
  const auto add = [&](const std::string& name, const std::string& dataset) {
    text += fmt::format(
        "<Attribute Name=\"{}\" AttributeType=\"Scalar\" Center=\"Cell\">\n<DataItem Format=\"HDF\" "
        "NumberType=\"Float\" "
        "Precision=\"8\" Dimensions=\"{}\">{}:{}</DataItem>\n</Attribute>\n",
        name, cells, escaped_for_markup(file), dataset);
  };
  for (const CentreField& field : flow.fields) add(field.name, "/centre/" + field.name);
  add("open", "/body/open");
  return text + "</Grid>\n</Domain>\n</Xdmf>\n";
}

}  // namespace samara::flow
