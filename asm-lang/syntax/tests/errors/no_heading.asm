signature: //~ L021
definitions:
  main rule r_Main = skip
