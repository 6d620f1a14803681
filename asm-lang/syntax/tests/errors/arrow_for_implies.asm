asm arrow_for_implies
signature:
definitions:
  main rule r_Main = if a -> b then skip endif //~ L009
