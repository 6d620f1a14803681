asm one_rule_before_ifnone
signature:
  controlled a: Integer
definitions:
  main rule r_Main =
    choose $x in {1, 2} do
      par choose $y in {3, 4} do a := $y endpar //~ L072
    ifnone a := 5
