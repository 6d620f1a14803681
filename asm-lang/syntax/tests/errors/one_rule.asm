asm one_rule
signature:
definitions:
  main rule r_Main = par skip endpar //~ L072
