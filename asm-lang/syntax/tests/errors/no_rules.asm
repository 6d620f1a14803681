asm no_rules
signature:
definitions:
  main rule r_Main = seq endseq //~ L072
