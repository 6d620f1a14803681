asm character_of_none
signature:
definitions:
  main rule r_Main = a := '' //~ L005
