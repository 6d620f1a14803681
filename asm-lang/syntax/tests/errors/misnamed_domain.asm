asm misnamed_domain
signature:
  domain speed subsetof Integer //~ L056
  controlled v: speed //~ L056
definitions:
