asm not_a_rule_value
import StandardLibrary
signature:
  controlled act: Rule
definitions:
  main rule r_Main = act  //~ R007
