asm operator_double_equals
signature:
definitions:
  main rule r_Main = if a == b then skip endif //~ L009
