asm agent_outside_init
signature:
definitions:
  rule r_a = skip
  agent Worker: r_a[] //~ L025
