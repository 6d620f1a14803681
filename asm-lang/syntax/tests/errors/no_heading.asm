signature: //~ L012
definitions:
  main rule r_Main = skip
