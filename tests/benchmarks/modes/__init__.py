"""Does the sampler miss a mode? Hard loops, their posteriors found in two other ways.

`cases` names ten hard loops and says why each is one. `annealed` is the reference: populations of
particles that start from the prior and are led to the posterior by raising the likelihood's power,
each population on its own, so that their spread is the reference's Monte-Carlo error. `nested` is
a check of it by another principle and another package (dynesty); neither knows the modes that
hdprog starts from. `fused` is hdprog's likelihood in one compiled loop, compared with it in every
case. `compare` sets hdprog's draws beside the reference's; `run` does it case by case; `summary`
and `picture` tell.
"""
