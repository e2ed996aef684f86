/* The frames in C beside which tests/Frames.cs runs the same in C#, and what they found. */
#include "../../c/tests/border.c"

const uint8_t *border_flags(void) { return flags; }
const uint32_t *border_slots(void) { return slots; }
const cullet_draw_command *border_commands(void) { return commands; }
