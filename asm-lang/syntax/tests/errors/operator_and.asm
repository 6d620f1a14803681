asm operator_and
signature:
definitions:
  main rule r_Main = if a && b then skip endif //~ L009
