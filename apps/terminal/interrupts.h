#pragma once

namespace samara::apps {

/// From now on Ctrl-C and SIGTERM end the program with a sentence and the documented exit code. Files appear whole or
/// not at all, so that none is half written then.
void end_when_interrupted();

/// From now on Ctrl-C and SIGTERM are remembered, so that long work can end in order; a second one ends the program at
/// once.
void catch_interrupts();

bool is_interrupted();

}  // namespace samara::apps
