asm operator_arrow
signature:
definitions:
  main rule r_Main = if a => b then skip endif //~ L009
