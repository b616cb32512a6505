// Index of this invocation; work-groups are laid out in rows because one dimension holds 65535 at most.
uint invocationIndex() {
  return (furrow_group.y * kGroupColumns + furrow_group.x) * kGroupSize + furrow_thread;
}
