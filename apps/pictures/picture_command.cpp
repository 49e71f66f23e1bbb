#include <fmt/format.h>

#include "inputs/flows.h"
#include "options/commands.h"
#include "samara/flow/files/flow_picture.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

int run(const PictureArguments& arguments) {
  check_output(arguments.output, {arguments.flow});
  const flow::StoredFlow stored = flow_of_file(arguments.flow, arguments.set, "--set");
  flow::PictureOptions options;
  options.field = arguments.field;
  options.pixels_per_cell = arguments.scale;
  options.streamlines = !arguments.no_streamlines;
  io::write_text_atomically(arguments.output, io::format_png(flow::draw_flow(stored, options)));
  tell_of_file(arguments.output, arguments.json);
  return kDone;
}

}  // namespace samara::apps
