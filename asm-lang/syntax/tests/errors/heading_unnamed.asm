asm
signature: //~ L058
definitions:
  main rule r_Main = skip
