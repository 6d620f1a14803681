asm cut_off_in_term
signature:
definitions:
  main rule r_Main = a := (1 + //~ L030
