asm infix_membership
signature:
definitions:
  main rule r_Main = if a in {1, 2} then skip endif //~ L060
